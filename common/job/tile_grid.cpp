#include "common/job/tile_grid.hpp"

#include <algorithm>
#include <cassert>

namespace tessera {

TileGrid::TileGrid(int film_width, int film_height, int tile_side)
    : TileGrid(film_width, film_height, tile_side, {0, 0, film_width, film_height}) {}

TileGrid::TileGrid(int film_width, int film_height, int tile_side, const Rect& window)
    : film_width_(film_width),
      film_height_(film_height),
      tile_side_(tile_side),
      window_(window),
      columns_(column_of(window.x + window.width - 1) + 1),
      rows_(row_of(window.y + window.height - 1) + 1) {
  assert(film_width > 0 && film_height > 0 && tile_side > 0);
  assert(window.x >= 0 && window.width > 0 && window.x + window.width <= film_width);
  assert(window.y >= 0 && window.height > 0 && window.y + window.height <= film_height);
}

Rect TileGrid::tile(std::uint32_t index) const {
  assert(index < count());
  const int column = static_cast<int>(index % static_cast<std::uint32_t>(columns_));
  const int row = static_cast<int>(index / static_cast<std::uint32_t>(columns_));
  const int x = (window_.x / tile_side_ + column) * tile_side_;
  const int y = (window_.y / tile_side_ + row) * tile_side_;
  const int left = std::max(x, window_.x), top = std::max(y, window_.y);
  return {left, top, std::min(x + tile_side_, window_.x + window_.width) - left,
          std::min(y + tile_side_, window_.y + window_.height) - top};
}

}  // namespace tessera
