#pragma once
#include <cstdint>
#include <vector>

#include "common/job/job_spec.hpp"
#include "common/job/tile_grid.hpp"

namespace tessera::server {

/// The order in which a frame's tiles are handed out: a tile's rank, and the tile of a rank. Eight
/// bytes a tile, once per job, made in O(tiles log tiles).
class TileRanks {
 public:
  /// A grid of more than `tiles_most` tiles is handed out in scanline order, which takes nothing.
  static constexpr std::uint32_t tiles_most = 1U << 20;
  TileRanks(const TileGrid& grid, TileOrder order);
  /// So many tiles in the order of their numbers.
  explicit TileRanks(std::uint32_t count) : count_(count) {}

  [[nodiscard]] std::uint32_t count() const { return count_; }
  [[nodiscard]] std::uint32_t tile(std::uint32_t rank) const {
    return tiles_.empty() ? rank : tiles_[rank];
  }
  [[nodiscard]] std::uint32_t rank(std::uint32_t tile) const {
    return ranks_.empty() ? tile : ranks_[tile];
  }

 private:
  std::uint32_t count_;
  std::vector<std::uint32_t> tiles_, ranks_;  // none: scanline
};

/// The tiles that a rectangle of pixels touches.
class FocusTiles {
 public:
  /// `focus` lies within the grid's window.
  FocusTiles(const TileGrid& grid, const Rect& focus);

  [[nodiscard]] bool contains(std::uint32_t tile) const {
    const std::uint32_t column = tile % columns_, row = tile / columns_;
    return column >= left_ && column <= right_ && row >= top_ && row <= bottom_;
  }
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (std::uint32_t row = top_; row <= bottom_; ++row)
      for (std::uint32_t column = left_; column <= right_; ++column) visit(row * columns_ + column);
  }

 private:
  std::uint32_t columns_, left_, right_, top_, bottom_;  // both ends belong to it
};

}  // namespace tessera::server
