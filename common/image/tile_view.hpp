#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "common/image/channels.hpp"
#include "common/image/tile.hpp"
#include "common/job/tile_grid.hpp"

/// One task's pixels where they stand, without a copy.
namespace tessera::image {

/// Floats one after another, aligned or not: in a file nothing says that they are.
class FloatRow {
 public:
  FloatRow(const std::byte* first, std::size_t size) : first_(first), size_(size) {}
  [[nodiscard]] std::size_t size() const { return size_; }
  float operator[](std::size_t i) const {
    float value = 0;
    std::memcpy(&value, first_ + i * sizeof value, sizeof value);
    return value;
  }

 private:
  const std::byte* first_;
  std::size_t size_;
};

/// What one pass of one tile gathered, looked at in the bytes of its checked EXR file, or in a
/// TileImage: those must outlive it.
struct TileView {
  Rect window;  ///< within the film, pixels
  int film_width = 0;
  int film_height = 0;
  std::array<std::uint32_t, group_count> samples{};  ///< as in TileImage
  std::vector<const std::byte*> lines;               ///< each row's bytes, from the upper one
  std::vector<std::size_t> offset_of;                ///< of each channel's values in a line
  Layout layout = default_layout();

  [[nodiscard]] std::size_t pixels() const { return static_cast<std::size_t>(window.pixels()); }
  [[nodiscard]] bool has_aovs() const { return samples[static_cast<std::size_t>(Group::aov)] != 0; }
  [[nodiscard]] std::size_t channels() const { return layout->travelling(has_aovs()); }
  [[nodiscard]] FloatRow row(std::size_t channel, std::size_t y) const {
    return {lines[y] + offset_of[channel], static_cast<std::size_t>(window.width)};
  }
};

/// `tile.values` has all the planes that travel.
TileView view_of(const TileImage& tile);

/// What decode_tile() checks, all of it, and throws; but the pixels stay where they are, in `exr`.
TileView view_tile(std::span<const std::byte> exr, const TileExpectation& expected);

}  // namespace tessera::image
