#pragma once
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

/// Picture files for tests, written by other means than what reads them.
namespace tessera::image {

using File = std::vector<std::byte>;
/// Samples row by row, interleaved; for 8 bits and less each in a byte of its own.
using Samples = std::vector<std::uint16_t>;

/// `color_type` as PNG counts them (0, 2, 4, 6); 1 to 16 bits.
File make_png(int width, int height, int bits, int color_type, const Samples& samples,
              bool interlaced = false);
File make_palette_png(int width, int height, const Samples& indices, const Samples& rgb,
                      const Samples& alphas);
File make_jpeg(int width, int height, int channels, const Samples& samples);
File make_webp(int width, int height, int channels, const Samples& samples);  ///< lossless
/// Rows from the lower one, as TGA has them unless told otherwise; `packed`: run lengths.
File make_tga(int width, int height, int channels, const Samples& samples, bool packed);
/// Four bytes a texel; by components, or one after another.
File make_hdr(int width, int height, const std::vector<std::uint8_t>& rgbe, bool packed);
/// `channels` as in "RGB"; half floats or floats.
File make_exr(int width, int height, std::string_view channels, bool halves,
              const std::vector<float>& planes);

}  // namespace tessera::image
