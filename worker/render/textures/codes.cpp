#include "worker/render/textures/codes.hpp"

#include "worker/render/fastmath.hpp"

namespace tessera::render {
namespace {

double srgb_to_linear(double encoded) {
  if (encoded <= 0.04045) return encoded / 12.92;
  return fast::exp(2.4 * fast::log((encoded + 0.055) / 1.055));
}

}  // namespace

CodeTable::CodeTable(std::size_t codes, scene::ColorSpace space)
    : values_(codes), first_(4 * codes) {
  for (std::size_t code = 0; code < codes; ++code) {
    const double share = static_cast<double>(code) / static_cast<double>(codes - 1);
    values_[code] =
        static_cast<float>(space == scene::ColorSpace::srgb ? srgb_to_linear(share) : share);
  }
  std::size_t code = 0;
  for (std::size_t part = 0; part < first_.size(); ++part) {
    const float least = static_cast<float>(part) / static_cast<float>(first_.size());
    while (values_[code] < least) ++code;
    first_[part] = static_cast<std::uint16_t>(code);
  }
}

std::uint16_t CodeTable::nearest(float linear) const {
  if (!(linear > 0)) return 0;
  if (linear >= values_.back()) return static_cast<std::uint16_t>(values_.size() - 1);
  std::size_t code = first_[static_cast<std::size_t>(linear * static_cast<float>(first_.size()))];
  while (values_[code] < linear) ++code;
  const bool below = linear - values_[code - 1] < values_[code] - linear;
  return static_cast<std::uint16_t>(below ? code - 1 : code);
}

const CodeTable& code_table(image::TexelFormat format, scene::ColorSpace space) {
  using scene::ColorSpace;
  if (format == image::TexelFormat::u8) {
    static const CodeTable plain(256, ColorSpace::linear);
    static const CodeTable curved(256, ColorSpace::srgb);
    return space == ColorSpace::srgb ? curved : plain;
  }
  if (space == ColorSpace::srgb) {
    static const CodeTable curved(65536, ColorSpace::srgb);
    return curved;
  }
  static const CodeTable plain(65536, ColorSpace::linear);
  return plain;
}

}  // namespace tessera::render
