#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "common/image/metadata.hpp"
#include "common/image/picture.hpp"
#include "common/job/tile_grid.hpp"

/// The bytes before an EXR file's pixels, laid by hand: OpenEXR's writer sorts, allocates and seeks
/// for what is a few hundred bytes known in advance. (OpenEXR, "The OpenEXR File Layout".)
namespace tessera::image {

/// One part of scan lines, every channel 32-bit float.
struct ExrLayout {
  Rect data;  ///< data window
  int film_width = 0;
  int film_height = 0;  ///< display window, from (0, 0)
  float pixel_aspect = 1;
  std::vector<std::string_view> channels;  ///< ascending by bytes
  Compression compression = Compression::none;

  [[nodiscard]] int lines_per_chunk() const { return compression == Compression::zip ? 16 : 1; }
  [[nodiscard]] std::size_t chunks() const {
    return static_cast<std::size_t>((data.height + lines_per_chunk() - 1) / lines_per_chunk());
  }
  [[nodiscard]] std::size_t line_bytes() const {
    return static_cast<std::size_t>(data.width) * channels.size() * sizeof(float);
  }
};

/// Magic to the header's end. `attributes` follow those that every file has; `chromaticities` are
/// Rec. 709's.
std::vector<std::byte> exr_header(const ExrLayout& layout,
                                  std::span<const Metadata::Attribute> attributes);

/// True for the names of attributes that say how a file is laid out.
bool is_layout_attribute(std::string_view name);

/// A name or message from outside as it can stand in an error: printable ASCII, at most 200 bytes.
std::string printable(std::string_view text);

}  // namespace tessera::image
