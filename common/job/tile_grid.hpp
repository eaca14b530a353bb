#pragma once
#include <cstdint>

namespace tessera {

/// A rectangle of pixels, x to the right and y down, from the film's upper left corner.
struct Rect {
  int x = 0, y = 0, width = 0, height = 0;
  bool operator==(const Rect&) const = default;
  [[nodiscard]] std::int64_t pixels() const { return static_cast<std::int64_t>(width) * height; }
};

/// How a film, or the window of it that is rendered, is cut: square tiles in rows from the film's
/// upper left, of which the window takes those that it touches, as far as they lie in it.
class TileGrid {
 public:
  TileGrid() = default;
  /// All in pixels, within the limits, the window within the film; anything else is a mistake of
  /// the caller's.
  TileGrid(int film_width, int film_height, int tile_side);
  TileGrid(int film_width, int film_height, int tile_side, const Rect& window);

  [[nodiscard]] std::uint32_t count() const {
    return static_cast<std::uint32_t>(columns_) * static_cast<std::uint32_t>(rows_);
  }
  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] int film_width() const { return film_width_; }
  [[nodiscard]] int film_height() const { return film_height_; }
  [[nodiscard]] int tile_side() const { return tile_side_; }
  [[nodiscard]] const Rect& window() const { return window_; }
  /// Where the tiles at a column or row of the window's pixels stand among the grid's, from 0.
  [[nodiscard]] int column_of(int x) const { return x / tile_side_ - window_.x / tile_side_; }
  [[nodiscard]] int row_of(int y) const { return y / tile_side_ - window_.y / tile_side_; }
  /// The pixels of tile `index` of the film, index < count().
  [[nodiscard]] Rect tile(std::uint32_t index) const;

 private:
  int film_width_ = 0, film_height_ = 0, tile_side_ = 1;
  Rect window_;
  int columns_ = 0, rows_ = 0;
};

}  // namespace tessera
