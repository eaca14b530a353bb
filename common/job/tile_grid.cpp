#include "common/job/tile_grid.hpp"

#include <algorithm>
#include <cassert>

namespace tessera {

TileGrid::TileGrid(int film_width, int film_height, int tile_side)
    : film_width_(film_width),
      film_height_(film_height),
      tile_side_(tile_side),
      columns_((film_width + tile_side - 1) / tile_side),
      rows_((film_height + tile_side - 1) / tile_side) {
  assert(film_width > 0 && film_height > 0 && tile_side > 0);
}

Rect TileGrid::tile(std::uint32_t index) const {
  assert(index < count());
  const int column = static_cast<int>(index % static_cast<std::uint32_t>(columns_));
  const int row = static_cast<int>(index / static_cast<std::uint32_t>(columns_));
  const int x = column * tile_side_;
  const int y = row * tile_side_;
  return {x, y, std::min(tile_side_, film_width_ - x), std::min(tile_side_, film_height_ - y)};
}

}  // namespace tessera
