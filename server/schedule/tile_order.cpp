#include "server/schedule/tile_order.hpp"

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <tuple>

namespace tessera::server {
namespace {

struct Step {
  int x = 0, y = 0;
  Step operator+(const Step& other) const { return {x + other.x, y + other.y}; }
  Step operator-(const Step& other) const { return {x - other.x, y - other.y}; }
  Step operator-() const { return {-x, -y}; }
  [[nodiscard]] Step half() const { return {x / 2, y / 2}; }
  /// One of them is 0.
  [[nodiscard]] int length() const { return std::abs(x + y); }
  [[nodiscard]] Step unit() const { return {(x > 0) - (x < 0), (y > 0) - (y < 0)}; }
};

/// Fills the rectangle that `along` and `across` span from `corner` with a Hilbert curve that runs
/// from there to the other end of `along` (a generalisation to any rectangle, after J. Červený):
/// each step goes to a neighbour, one step at most to a diagonal one. Odd halves are made even, for
/// a curve through an even side ends where the next part begins.
template <class Visit>
void walk_hilbert(Step corner, Step along, Step across, const Visit& visit) {
  const int length = along.length(), width = across.length();
  if (width == 1 || length == 1) {
    const Step step = width == 1 ? along.unit() : across.unit();
    for (int i = 0; i < std::max(length, width); ++i, corner = corner + step) visit(corner);
    return;
  }
  Step half_along = along.half(), half_across = across.half();
  if (2 * length > 3 * width) {  // long: two in a row
    if (half_along.length() % 2 != 0 && length > 2) half_along = half_along + along.unit();
    walk_hilbert(corner, half_along, across, visit);
    walk_hilbert(corner + half_along, along - half_along, across, visit);
    return;
  }
  if (half_across.length() % 2 != 0 && width > 2) half_across = half_across + across.unit();
  // Up, along, and down again.
  walk_hilbert(corner, half_across, half_along, visit);
  walk_hilbert(corner + half_across, along, across - half_across, visit);
  walk_hilbert(corner + (along - along.unit()) + (half_across - across.unit()), -half_across,
               -(along - half_along), visit);
}

std::vector<std::uint32_t> hilbert(const TileGrid& grid) {
  std::vector<std::uint32_t> tiles;
  tiles.reserve(grid.count());
  const Step right{grid.columns(), 0}, down{0, grid.rows()};
  const bool wide = grid.columns() >= grid.rows();
  walk_hilbert({0, 0}, wide ? right : down, wide ? down : right, [&](const Step& at) {
    tiles.push_back(static_cast<std::uint32_t>(at.y * grid.columns() + at.x));
  });
  return tiles;
}

std::vector<std::uint32_t> from_center(const TileGrid& grid) {
  std::vector<std::uint32_t> tiles(grid.count());
  std::iota(tiles.begin(), tiles.end(), 0U);
  const auto distance = [&](std::uint32_t tile) {  // squared, in half pixels
    const Rect rect = grid.tile(tile);
    const Rect& all = grid.window();
    const std::int64_t x = 2LL * (rect.x - all.x) + rect.width - all.width;
    const std::int64_t y = 2LL * (rect.y - all.y) + rect.height - all.height;
    return x * x + y * y;
  };
  std::sort(tiles.begin(), tiles.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(distance(a), a) < std::tuple(distance(b), b);
  });
  return tiles;
}

}  // namespace

TileRanks::TileRanks(const TileGrid& grid, TileOrder order) : count_(grid.count()) {
  if (order == TileOrder::scanline || count_ > tiles_most) return;
  tiles_ = order == TileOrder::hilbert ? hilbert(grid) : from_center(grid);
  ranks_.resize(count_);
  for (std::uint32_t rank = 0; rank < count_; ++rank) ranks_[tiles_[rank]] = rank;
}

FocusTiles::FocusTiles(const TileGrid& grid, const Rect& focus)
    : columns_(static_cast<std::uint32_t>(grid.columns())),
      left_(static_cast<std::uint32_t>(grid.column_of(focus.x))),
      right_(static_cast<std::uint32_t>(grid.column_of(focus.x + focus.width - 1))),
      top_(static_cast<std::uint32_t>(grid.row_of(focus.y))),
      bottom_(static_cast<std::uint32_t>(grid.row_of(focus.y + focus.height - 1))) {}

}  // namespace tessera::server
