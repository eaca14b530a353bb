#include <gmock/gmock.h>
#include <png.h>

#include <cmath>
#include <limits>
#include <random>

#include "common/base/error.hpp"
#include "common/image/picture.hpp"

namespace tessera::image {
namespace {

/// The codes of an 8-bit RGB PNG, as libpng reads it; nothing is converted.
std::vector<int> decode_png(const std::vector<std::byte>& bytes, int width, int height) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()), 0)
      << image.message;
  EXPECT_EQ(image.format, PNG_FORMAT_RGB);
  EXPECT_EQ(static_cast<int>(image.width), width);
  EXPECT_EQ(static_cast<int>(image.height), height);
  std::vector<std::uint8_t> codes(PNG_IMAGE_SIZE(image));
  EXPECT_NE(png_image_finish_read(&image, nullptr, codes.data(), 0, nullptr), 0) << image.message;
  return {codes.begin(), codes.end()};
}

/// IEC 61966-2-1, as it is written there.
int srgb_code(double linear) {
  const double value = std::clamp(linear, 0.0, 1.0);
  const double encoded =
      value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
  return static_cast<int>(std::lround(255 * encoded));
}

TEST(Png, has_the_code_that_the_sRGB_curve_gives_for_any_value) {
  constexpr int side = 128;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> exponent(-16, 1);
  std::vector<float> rgb(3 * side * side);
  for (float& value : rgb) value = static_cast<float>(std::exp2(exponent(random)));
  const auto codes = decode_png(encode_png(side, side, rgb), side, side);
  int off = 0;
  for (std::size_t i = 0; i < side * side; ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const double linear = rgb[c * side * side + i];
      // Where the curve's two published constants disagree by less than a millionth, either
      // neighbour is right.
      const bool sure = srgb_code(linear * (1 - 1e-6)) == srgb_code(linear * (1 + 1e-6));
      if (sure && codes[3 * i + c] != srgb_code(linear)) ++off;
    }
  EXPECT_EQ(off, 0);
}

TEST(Png, clips_and_shows_nothing_for_what_is_no_number) {
  const float inf = std::numeric_limits<float>::infinity(),
              nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> rgb{0,  1,    2,      inf,   -inf,       nan,
                               -1, 0.5F, 1e-30F, -0.0F, 0.9999999F, 0.2158605F};
  EXPECT_EQ(decode_png(encode_png(4, 1, rgb), 4, 1),
            (std::vector<int>{0, 0, 0, 255, 0, 0, 255, 0, 255, 255, 188, 128}));
}

TEST(Png, exposure_multiplies_by_powers_of_two_before_clipping) {
  const std::vector<float> rgb{0.25F, 0.125F, 4.0F};
  EXPECT_EQ(decode_png(encode_png(1, 1, rgb, 1), 1, 1),
            (std::vector<int>{srgb_code(0.5), srgb_code(0.25), 255}));
  EXPECT_EQ(decode_png(encode_png(1, 1, rgb, -3), 1, 1),
            (std::vector<int>{srgb_code(0.03125), srgb_code(0.015625), srgb_code(0.5)}));
}

TEST(Png, shows_premultiplied_colour_over_black_and_does_not_read_alpha) {
  const std::vector<float> rgba{0, 0.5F, 0, 0.5F, 0, 0.5F, /* alpha */ 0, 0.5F};
  EXPECT_EQ(decode_png(encode_png(2, 1, rgba), 2, 1), (std::vector<int>{0, 0, 0, 188, 188, 188}));
}

TEST(Png, refuses_an_exposure_that_is_no_sensible_number) {
  const std::vector<float> rgb(3);
  for (const double stops : {65.0, -65.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    try {
      encode_png(1, 1, rgb, stops);
      ADD_FAILURE() << stops;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::bad_input);
      EXPECT_EQ(error.place().key, "exposure");
    }
  }
}

TEST(Png, has_equal_bytes_for_equal_pictures) {
  const std::vector<float> rgb(3 * 20 * 20, 0.3F);
  EXPECT_EQ(encode_png(20, 20, rgb), encode_png(20, 20, rgb));
}

}  // namespace
}  // namespace tessera::image
