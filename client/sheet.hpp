#pragma once
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "client/output.hpp"
#include "client/sheet_layout.hpp"
#include "common/image/picture.hpp"

namespace tessera::client {

/// A contact sheet being drawn: text at once, pictures one by one, then all as a PNG.
class Sheet {
 public:
  Sheet(SheetLayout layout, int cell_width, int cell_height);

  /// Puts a picture in the middle of its cell: as PNG pictures are made, by this look. One
  /// that is wider than `width_most` is scaled down, by the mean over the area of each new pixel.
  void place(std::size_t cell, const image::ExrImage& picture, int width_most, const Look& look);
  /// In the place of a picture that is not there.
  void place_words(std::size_t cell, const std::string& words);
  [[nodiscard]] std::vector<std::byte> png() const;

 private:
  void dot(std::size_t channel, int x, int y, float value);
  /// On `ground`, a colour as sRGB encodes it.
  void draw(const PlacedText& text, const std::array<double, 3>& ground);

  SheetLayout layout_;
  int cell_width_, cell_height_;
  std::vector<float> planes_;  ///< linear R, G, B
};

/// A plane of `width` × `height` values scaled to `to`: each new value is the mean over the area
/// that it covers. Neither side grows.
std::vector<float> scaled_down(std::span<const float> plane, PictureSize from, PictureSize to);

}  // namespace tessera::client
