#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "worker/render/textures/codes.hpp"
#include "worker/render/textures/texture_table.hpp"

namespace tessera::render {
namespace {

using image::TexelFormat;
using image::Texels;
using scene::ColorSpace;
using scene::Wrap;

double srgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

/// Codes that look like noise; floats are such codes over 255.
Texels noise(int width, int height, int channels, TexelFormat format) {
  Texels out{width, height, channels, format, {}};
  std::uint32_t state = 12345;
  for (int i = 0; i < width * height * channels; ++i) {
    state = state * 1664525U + 1013904223U;
    const std::uint32_t code = state >> 24;
    const auto put = [&](auto value) {
      const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
      out.bytes.insert(out.bytes.end(), bytes, bytes + sizeof value);
    };
    if (format == TexelFormat::u8) put(static_cast<std::uint8_t>(code));
    if (format == TexelFormat::u16) put(static_cast<std::uint16_t>(code * 257));
    if (format == TexelFormat::f32) put(static_cast<float>(code) / 255.0F);
    // Halves of 1 + code/1024.
    if (format == TexelFormat::f16) put(static_cast<std::uint16_t>(0x3c00U + code));
  }
  return out;
}

Texels gray(int width, int height, const std::vector<int>& codes) {
  Texels out{width, height, 1, TexelFormat::u8, {}};
  for (const int code : codes) out.bytes.push_back(static_cast<std::byte>(code));
  return out;
}

TextureTable table_of(Texels picture, Wrap wrap = Wrap::repeat, bool nearest = false) {
  return TextureTable(
      {Texture{std::make_shared<const Pyramid>(std::move(picture), ColorSpace::linear), wrap, wrap,
               nearest}});
}

float at(const TextureTable& table, float u, float v, float across = 0, float along = 0) {
  TexturePoint point;
  point.uv = {u, v};
  point.across = {across, 0};
  point.along = {0, along};
  return table.lookup(TextureUse{}, point)[0];
}

TEST(Codes, decode_by_the_curve_and_come_back) {
  for (const TexelFormat format : {TexelFormat::u8, TexelFormat::u16}) {
    const int most = format == TexelFormat::u8 ? 255 : 65535;
    for (const ColorSpace space : {ColorSpace::srgb, ColorSpace::linear}) {
      const CodeTable& table = code_table(format, space);
      for (int code = 0; code <= most; ++code) {
        const double share = static_cast<double>(code) / most;
        const double expected = space == ColorSpace::srgb ? srgb(share) : share;
        ASSERT_NEAR(table.values()[code], expected, 6e-8 * expected) << code;
        ASSERT_EQ(table.nearest(table.values()[code]), code);
      }
      EXPECT_EQ(table.values()[most], 1);
      EXPECT_EQ(table.nearest(-1), 0);
      EXPECT_EQ(table.nearest(2), most);
    }
  }
}

TEST(Codes, nearest_is_the_nearest_of_all) {
  for (const ColorSpace space : {ColorSpace::srgb, ColorSpace::linear}) {
    const CodeTable& table = code_table(TexelFormat::u8, space);
    for (int i = 0; i < 20'000; ++i) {
      const float share = static_cast<float>(i) / 20'000, linear = share * share;
      const float found = table.values()[table.nearest(linear)];
      for (int code = 0; code < 256; ++code)
        ASSERT_LE(std::abs(found - linear), std::abs(table.values()[code] - linear)) << linear;
    }
  }
}

TEST(Pyramid, each_format_gives_its_values_and_lacking_channels_are_made_up) {
  for (const TexelFormat format :
       {TexelFormat::u8, TexelFormat::u16, TexelFormat::f16, TexelFormat::f32}) {
    const std::size_t size = image::bytes_of(format);
    for (int channels = 1; channels <= 4; ++channels) {
      const Texels picture = noise(3, 2, channels, format);
      Texels copy = picture;
      const Pyramid pyramid(std::move(copy), ColorSpace::srgb);
      const Texel found = pyramid.texel(pyramid.level(0), 2, 1);
      const auto value = [&](int channel, bool alpha) {
        const std::byte* from =
            picture.bytes.data() + static_cast<std::size_t>(5 * channels + channel) * size;
        if (format == TexelFormat::f32)
          return double{std::bit_cast<float>([&] {
            std::array<std::byte, 4> bytes;
            std::memcpy(bytes.data(), from, 4);
            return bytes;
          }())};
        const int low = std::to_integer<int>(from[0]);
        if (format == TexelFormat::f16) return 1 + low / 1024.0;
        return alpha ? low / 255.0 : srgb(low / 255.0);  // 16 bits repeat the 8
      };
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(found[static_cast<std::size_t>(c)], value(channels < 3 ? 0 : c, false), 1e-6);
      EXPECT_NEAR(found[3], channels % 2 == 0 ? value(channels - 1, true) : 1.0, 1e-6);
    }
  }
}

std::array<double, 4> mean_of(const Pyramid& pyramid, int number) {
  const Pyramid::Level& level = pyramid.level(number);
  std::array<double, 4> sum{};
  for (int y = 0; y < level.height; ++y)
    for (int x = 0; x < level.width; ++x)
      for (std::size_t c = 0; c < 4; ++c) sum[c] += pyramid.texel(level, x, y)[c];
  for (double& one : sum) one /= level.width * level.height;
  return sum;
}

TEST(Pyramid, every_level_keeps_the_mean_whatever_the_size) {
  for (const TexelFormat format :
       {TexelFormat::u8, TexelFormat::u16, TexelFormat::f16, TexelFormat::f32}) {
    for (const auto& [width, height] : {std::pair{64, 64}, {37, 50}, {1, 9}, {100, 1}}) {
      const Pyramid pyramid(noise(width, height, 4, format), ColorSpace::srgb);
      const Pyramid::Level& last = pyramid.level(pyramid.levels() - 1);
      EXPECT_EQ(last.width, 1);
      EXPECT_EQ(last.height, 1);
      // Half a step of the format: what rounding once may do.
      const double step = format == TexelFormat::u8    ? 0.5 / 255 * 2.3
                          : format == TexelFormat::f16 ? 0x1p-11
                                                       : 2e-5;
      const std::array<double, 4> mean = mean_of(pyramid, 0);
      for (int number = 1; number < pyramid.levels(); ++number)
        for (std::size_t c = 0; c < 4; ++c)
          ASSERT_NEAR(mean_of(pyramid, number)[c], mean[c], step)
              << number << " of " << width << " by " << height;
    }
  }
}

TEST(Pyramid, srgb_is_averaged_as_light) {
  Texels picture = gray(2, 2, {0, 255, 255, 0});
  const Pyramid pyramid(std::move(picture), ColorSpace::srgb);
  EXPECT_NEAR(pyramid.texel(pyramid.level(1), 0, 0)[0], 0.5F, 0.003F);
  EXPECT_EQ(std::to_integer<int>(pyramid.level(1).bytes[0]), 188);
}

TEST(Pyramid, bits_do_not_depend_on_threads) {
  const tbb::global_control four(tbb::global_control::max_allowed_parallelism, 4);
  std::vector<Pyramid> made;
  for (const int threads : {1, 4}) {
    tbb::task_arena arena(threads);
    arena.execute(
        [&] { made.emplace_back(noise(301, 200, 3, TexelFormat::u8), ColorSpace::srgb); });
  }
  ASSERT_EQ(made[0].levels(), made[1].levels());
  for (int i = 0; i < made[0].levels(); ++i)
    EXPECT_EQ(made[0].level(i).bytes, made[1].level(i).bytes);
}

TEST(Lookup, is_bilinear_between_texel_centres_and_exact_on_them) {
  const TextureTable table = table_of(gray(4, 1, {0, 51, 102, 255}), Wrap::clamp_to_edge);
  EXPECT_FLOAT_EQ(at(table, 0.375F, 0.5F), 0.2F);
  EXPECT_FLOAT_EQ(at(table, 0.5F, 0.5F), 0.3F);
  EXPECT_FLOAT_EQ(at(table, 0.125F, 0.2F), 0);
  // A footprint of less than a texel changes nothing.
  EXPECT_EQ(at(table, 0.41F, 0.5F, 0.24F, 0.9F), at(table, 0.41F, 0.5F));
}

TEST(Lookup, wraps_exactly_at_edges) {
  const std::vector<int> codes{0, 51, 102, 255};
  const TextureTable repeat = table_of(gray(4, 1, codes));
  EXPECT_FLOAT_EQ(at(repeat, 0, 0.5F), 0.5F);  // between the last and the first
  for (const float u : {0.0625F, 0.3F, 0.96875F}) {
    EXPECT_EQ(at(repeat, u + 3, 0.5F), at(repeat, (u + 3) - 3, 0.5F));
    EXPECT_EQ(at(repeat, u - 2, 0.5F), at(repeat, (u - 2) + 2, 0.5F));
  }
  const TextureTable mirrored = table_of(gray(4, 1, codes), Wrap::mirrored_repeat);
  EXPECT_FLOAT_EQ(at(mirrored, 0, 0.5F), 0);
  EXPECT_FLOAT_EQ(at(mirrored, 1, 0.5F), 1);
  EXPECT_EQ(at(mirrored, 1.25F, 0.5F), at(mirrored, 0.75F, 0.5F));
  EXPECT_EQ(at(mirrored, -0.25F, 0.5F), at(mirrored, 0.25F, 0.5F));
  EXPECT_EQ(at(mirrored, 2.25F, 0.5F), at(mirrored, 0.25F, 0.5F));
  const TextureTable clamped = table_of(gray(4, 1, codes), Wrap::clamp_to_edge);
  EXPECT_FLOAT_EQ(at(clamped, -7, 0.5F), 0);
  EXPECT_FLOAT_EQ(at(clamped, 9, 0.5F), 1);
  const float bad = std::nanf("");
  for (const TextureTable* table : {&repeat, &mirrored, &clamped}) {
    EXPECT_TRUE(std::isfinite(at(*table, bad, 1e38F)));
    EXPECT_TRUE(std::isfinite(at(*table, 0.3F, 0.3F, bad, 1e38F)));
    EXPECT_TRUE(std::isfinite(at(*table, 0.3F, 0.3F, 1e30F, 1e30F)));
  }
}

TEST(Lookup, nearest_texels_stay_squares_while_magnified) {
  const TextureTable table = table_of(gray(2, 1, {0, 255}), Wrap::repeat, true);
  EXPECT_EQ(at(table, 0.001F, 0.5F), 0);
  EXPECT_EQ(at(table, 0.499F, 0.5F), 0);
  EXPECT_EQ(at(table, 0.501F, 0.5F), 1);
  EXPECT_EQ(at(table, 0.999F, 0.5F), 1);
  EXPECT_NEAR(at(table, 0.3F, 0.5F, 1, 1), 0.5F, 0.003F);  // minified
}

TEST(Lookup, a_wide_footprint_gives_the_mean_and_one_of_2n_texels_level_n) {
  const TextureTable table = table_of(noise(64, 64, 3, TexelFormat::f32));
  const Pyramid pyramid(noise(64, 64, 3, TexelFormat::f32), ColorSpace::linear);
  EXPECT_NEAR(at(table, 0.3F, 0.3F, 3, 3), mean_of(pyramid, 0)[0], 1e-5);
  const float width = 8.0F / 64;
  EXPECT_NEAR(at(table, 2.5F / 8, 3.5F / 8, width, width), pyramid.texel(pyramid.level(3), 2, 3)[0],
              1e-6);
}

TEST(Lookup, a_long_footprint_blurs_along_its_long_axis_alone) {
  std::vector<int> columns, rows;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      columns.push_back(x < 32 ? 0 : 255);
      rows.push_back(y % 2 == 0 ? 0 : 255);
    }
  // Long along v: the edge between columns stays sharp, the stripes across it become gray.
  EXPECT_LT(at(table_of(gray(64, 64, columns)), 0.47F, 0.5F, 1.0F / 64, 12.0F / 64), 0.01F);
  EXPECT_NEAR(at(table_of(gray(64, 64, rows)), 0.47F, 0.5F, 1.0F / 64, 12.0F / 64), 0.5F, 0.06F);
}

TEST(Lookup, the_use_transforms_coordinates_and_footprint) {
  const TextureTable table = table_of(gray(4, 1, {0, 51, 102, 255}), Wrap::clamp_to_edge);
  scene::TextureUse described;
  described.to_uv = {0, 2, 0.125, 1, 0, 0};
  TexturePoint point;
  point.uv = {0.3F, 0.125F};
  EXPECT_FLOAT_EQ(table.lookup(compile(described), point)[0], 0.2F);
  point.along = {0, 2};  // along the picture's u, over all of it
  const float blurred = table.lookup(compile(described), point)[0];
  EXPECT_GT(blurred, 0.25F);
}

}  // namespace
}  // namespace tessera::render
