#include <fmt/format.h>
#include <png.h>

#include <array>
#include <bit>
#include <cassert>
#include <cmath>

#include "common/base/error.hpp"
#include "common/image/exr_layout.hpp"
#include "common/image/picture.hpp"

namespace tessera::image {

namespace {

/// sRGB's 8-bit code for a linear value, rounded exactly as the curve of IEC 61966-2-1 says: the
/// codes' lower bounds as a table, entered by exponent and upper mantissa bits.
class SrgbEncoder {
 public:
  SrgbEncoder() {
    for (std::size_t code = 1; code < bounds_.size(); ++code)
      bounds_[code] = static_cast<float>(linear((static_cast<double>(code) - 0.5) / 255));
    std::size_t code = 0;
    for (std::size_t i = 0; i < first_.size(); ++i) {
      const auto least =
          std::bit_cast<float>(lowest_bits + (static_cast<std::uint32_t>(i) << shift));
      while (code < 255 && least >= bounds_[code + 1]) ++code;
      first_[i] = static_cast<std::uint8_t>(code);
    }
  }

  [[nodiscard]] std::uint8_t operator()(float value) const {
    if (!(value >= std::bit_cast<float>(lowest_bits))) return 0;  // NaN too
    if (value >= 1) return 255;
    std::size_t code = first_[(std::bit_cast<std::uint32_t>(value) - lowest_bits) >> shift];
    while (code < 255 && value >= bounds_[code + 1]) ++code;
    return static_cast<std::uint8_t>(code);
  }

 private:
  static double linear(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
  }
  static constexpr std::uint32_t lowest_bits = 0x39000000;  ///< 2^-13, below the first code's bound
  static constexpr std::uint32_t one_bits = 0x3f800000;
  /// 256 steps an octave: never more than one bound within a step.
  static constexpr unsigned shift = 15;
  std::array<float, 256> bounds_{};
  std::array<std::uint8_t, ((one_bits - lowest_bits) >> shift)> first_{};
};

}  // namespace

std::vector<std::byte> encode_png(int width, int height, std::span<const float> rgb,
                                  double exposure_stops) {
  constexpr double most_stops = 64;
  if (!(exposure_stops >= -most_stops && exposure_stops <= most_stops))
    throw Error(ErrorKind::bad_input,
                fmt::format("expected a number of stops from {} to {}, found {}", -most_stops,
                            most_stops, exposure_stops),
                {.key = "exposure"});
  static const SrgbEncoder encoder;
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  assert(rgb.size() >= 3 * pixels);
  const auto scale = static_cast<float>(std::exp2(exposure_stops));
  std::vector<std::uint8_t> codes(3 * pixels);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const std::span<const float> plane = rgb.subspan(channel * pixels, pixels);
    for (std::size_t i = 0; i < pixels; ++i) codes[3 * i + channel] = encoder(plane[i] * scale);
  }
  return encode_png(width, height, codes);
}

std::vector<std::byte> encode_png(int width, int height, std::span<const std::uint8_t> rgb) {
  assert(rgb.size() == 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_RGB;
  image.flags = PNG_IMAGE_FLAG_FAST;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::vector<std::byte> out(size);
  if (png_image_write_to_memory(&image, out.data(), &size, 0, rgb.data(), 0, nullptr) == 0)
    throw Error(ErrorKind::failed,
                fmt::format("encoding a PNG failed: {}", printable(image.message)));
  out.resize(size);
  return out;
}

}  // namespace tessera::image
