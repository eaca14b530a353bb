#include "worker/render/textures/codes.hpp"

#include <algorithm>
#include <vector>

#include "worker/render/fastmath.hpp"

namespace tessera::render {
namespace {

double srgb_to_linear(double encoded) {
  if (encoded <= 0.04045) return encoded / 12.92;
  return fast::exp(2.4 * fast::log((encoded + 0.055) / 1.055));
}

std::vector<float> make_table(std::size_t codes, scene::ColorSpace space) {
  std::vector<float> table(codes);
  for (std::size_t code = 0; code < codes; ++code) {
    const double share = static_cast<double>(code) / static_cast<double>(codes - 1);
    table[code] =
        static_cast<float>(space == scene::ColorSpace::srgb ? srgb_to_linear(share) : share);
  }
  return table;
}

}  // namespace

const float* decoding_table(image::TexelFormat format, scene::ColorSpace space) {
  using scene::ColorSpace;
  if (format == image::TexelFormat::u8) {
    static const std::vector<float> plain = make_table(256, ColorSpace::linear);
    static const std::vector<float> curved = make_table(256, ColorSpace::srgb);
    return space == ColorSpace::srgb ? curved.data() : plain.data();
  }
  if (space == ColorSpace::srgb) {
    static const std::vector<float> curved = make_table(65536, ColorSpace::srgb);
    return curved.data();
  }
  static const std::vector<float> plain = make_table(65536, ColorSpace::linear);
  return plain.data();
}

std::uint16_t nearest_code(const float* table, image::TexelFormat format, float linear) {
  const std::size_t codes = format == image::TexelFormat::u8 ? 256 : 65536;
  const float* const above = std::lower_bound(table, table + codes, linear);
  if (above == table) return 0;
  const auto code = static_cast<std::size_t>(above - table);
  if (code == codes) return static_cast<std::uint16_t>(codes - 1);
  const bool below = linear - table[code - 1] < table[code] - linear;
  return static_cast<std::uint16_t>(below ? code - 1 : code);
}

}  // namespace tessera::render
