// In which order tiles are handed out.
#include "server/schedule/tile_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <vector>

namespace tessera::server {
namespace {

std::vector<std::uint32_t> sequence(const TileGrid& grid, TileOrder order) {
  const TileRanks ranks(grid, order);
  std::vector<std::uint32_t> tiles;
  for (std::uint32_t rank = 0; rank < ranks.count(); ++rank) {
    tiles.push_back(ranks.tile(rank));
    EXPECT_EQ(ranks.rank(tiles.back()), rank);
  }
  return tiles;
}

TEST(TileOrder, EveryOrderHasEveryTileOfEveryGridOnce) {
  for (int width = 1; width <= 40; ++width) {
    for (int height = 1; height <= 40; ++height) {
      const TileGrid grid(width, height, 1);
      for (const TileOrder order : {TileOrder::hilbert, TileOrder::center, TileOrder::scanline}) {
        const auto tiles = sequence(grid, order);
        ASSERT_EQ(std::set(tiles.begin(), tiles.end()).size(), grid.count())
            << width << " by " << height << ", " << name_of(order);
      }
    }
  }
}

TEST(TileOrder, TheHilbertCurveGoesFromNeighbourToNeighbour) {
  for (int width = 1; width <= 70; width += 3) {
    for (int height = 1; height <= 70; height += 4) {
      const TileGrid grid(width, height, 1);
      const auto tiles = sequence(grid, TileOrder::hilbert);
      int diagonal = 0;
      for (std::size_t i = 1; i < tiles.size(); ++i) {
        const Rect from = grid.tile(tiles[i - 1]), to = grid.tile(tiles[i]);
        const int x = std::abs(from.x - to.x), y = std::abs(from.y - to.y);
        ASSERT_LE(std::max(x, y), 1) << width << " by " << height << " at " << i;
        diagonal += x + y == 2;
      }
      EXPECT_LE(diagonal, 1) << width << " by " << height;
    }
  }
}

TEST(TileOrder, TheHilbertCurveKeepsWhatIsHandedOutTogetherTogether) {
  // 60 by 34 tiles, as of a 4K frame: any 64 in a row lie within a small box.
  const TileGrid grid(3840, 2160, 64);
  const auto tiles = sequence(grid, TileOrder::hilbert);
  for (std::size_t i = 0; i + 64 <= tiles.size(); ++i) {
    int left = 100, right = 0;
    for (std::size_t k = i; k < i + 64; ++k) {
      left = std::min(left, grid.tile(tiles[k]).x / 64);
      right = std::max(right, grid.tile(tiles[k]).x / 64);
    }
    ASSERT_LE(right - left, 24) << "from rank " << i;
  }
}

TEST(TileOrder, FromTheCenterTheDistanceOnlyGrows) {
  const TileGrid grid(250, 131, 16);
  double last = 0;
  for (const std::uint32_t tile : sequence(grid, TileOrder::center)) {
    const Rect rect = grid.tile(tile);
    const double x = rect.x + rect.width / 2.0 - 125, y = rect.y + rect.height / 2.0 - 65.5;
    EXPECT_GE(x * x + y * y, last);
    last = x * x + y * y;
  }
}

TEST(TileOrder, AGridOfMoreThanAMillionTilesIsInScanlineOrder) {
  const TileGrid grid(2000, 1000, 1);
  const TileRanks ranks(grid, TileOrder::hilbert);
  EXPECT_EQ(ranks.tile(2001), 2001U);
}

TEST(TileOrder, AFocusIsTheTilesThatItTouches) {
  const TileGrid grid(250, 131, 16);  // 16 by 9 tiles
  for (const Rect& focus : {Rect{0, 0, 1, 1}, Rect{15, 15, 2, 2}, Rect{249, 130, 1, 1},
                            Rect{32, 16, 16, 16}, Rect{0, 0, 250, 131}}) {
    const FocusTiles tiles(grid, focus);
    std::set<std::uint32_t> visited;
    tiles.for_each([&](std::uint32_t tile) { visited.insert(tile); });
    for (std::uint32_t tile = 0; tile < grid.count(); ++tile) {
      const Rect rect = grid.tile(tile);
      const bool touches = rect.x < focus.x + focus.width && focus.x < rect.x + rect.width &&
                           rect.y < focus.y + focus.height && focus.y < rect.y + rect.height;
      EXPECT_EQ(tiles.contains(tile), touches);
      EXPECT_EQ(visited.contains(tile), touches);
    }
  }
}

}  // namespace
}  // namespace tessera::server
