#include "common/image/texels.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <half.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "tests/unit/image/encode_texels.hpp"

namespace tessera::image {
namespace {

template <class Value>
std::vector<double> values_of(const Texels& picture) {
  std::vector<double> out;
  for (std::size_t at = 0; at < picture.bytes.size(); at += sizeof(Value)) {
    Value value;
    std::memcpy(&value, picture.bytes.data() + at, sizeof value);
    out.push_back(static_cast<double>(value));
  }
  return out;
}

Samples ramp(int count, int most) {
  Samples out;
  for (int i = 0; i < count; ++i)
    out.push_back(static_cast<std::uint16_t>((i * 7919 + 13) % (most + 1)));
  return out;
}

void expect_same(const Texels& picture, const Samples& samples, int scale = 1) {
  const auto found = picture.format == TexelFormat::u8 ? values_of<std::uint8_t>(picture)
                                                       : values_of<std::uint16_t>(picture);
  ASSERT_EQ(found.size(), samples.size());
  for (std::size_t i = 0; i < found.size(); ++i) ASSERT_EQ(found[i], samples[i] * scale) << i;
}

TEST(Texels, png_of_every_depth_and_colour_type_is_read_as_it_stands) {
  for (const int bits : {8, 16}) {
    for (const auto& [color_type, channels] : {std::pair{0, 1}, {4, 2}, {2, 3}, {6, 4}}) {
      for (const bool interlaced : {false, true}) {
        const Samples samples = ramp(5 * 3 * channels, (1 << bits) - 1);
        const Texels picture =
            decode_texels(make_png(5, 3, bits, color_type, samples, interlaced), "p.png");
        EXPECT_EQ(picture.width, 5);
        EXPECT_EQ(picture.height, 3);
        EXPECT_EQ(picture.channels, channels);
        EXPECT_EQ(picture.format, bits == 8 ? TexelFormat::u8 : TexelFormat::u16);
        expect_same(picture, samples);
      }
    }
  }
  for (const int bits : {1, 2, 4}) {
    const Samples samples = ramp(15, (1 << bits) - 1);
    const Texels picture = decode_texels(make_png(5, 3, bits, 0, samples), "p.png");
    EXPECT_EQ(picture.channels, 1);
    expect_same(picture, samples, 255 / ((1 << bits) - 1));
  }
}

TEST(Texels, a_palette_becomes_its_colours_and_alphas) {
  const Samples rgb{10, 20, 30, 40, 50, 60, 70, 80, 90};
  const Texels plain = decode_texels(make_palette_png(3, 1, {2, 0, 1}, rgb, {}), "p.png");
  EXPECT_EQ(plain.channels, 3);
  expect_same(plain, {70, 80, 90, 10, 20, 30, 40, 50, 60});
  const Texels clear = decode_texels(make_palette_png(3, 1, {2, 0, 1}, rgb, {255, 128}), "p.png");
  EXPECT_EQ(clear.channels, 4);
  expect_same(clear, {70, 80, 90, 255, 10, 20, 30, 255, 40, 50, 60, 128});
}

TEST(Texels, jpeg_gray_and_colour_come_back_within_its_losses) {
  for (const int channels : {1, 3}) {
    Samples samples;
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x)
        for (int c = 0; c < channels; ++c)
          samples.push_back(static_cast<std::uint16_t>(60 + 8 * x + (c == 1 ? 20 : 0)));
    const Texels picture = decode_texels(make_jpeg(16, 16, channels, samples), "p.jpg");
    ASSERT_EQ(picture.channels, channels);
    const auto found = values_of<std::uint8_t>(picture);
    for (std::size_t i = 0; i < found.size(); ++i) ASSERT_NEAR(found[i], samples[i], 5) << i;
  }
  EXPECT_THROW(decode_texels(make_jpeg(8, 8, 4, ramp(256, 255)), "p.jpg"), Error);
}

TEST(Texels, webp_and_tga_are_read_as_they_stand) {
  for (const int channels : {3, 4}) {
    Samples samples = ramp(6 * 4 * channels, 255);
    if (channels == 4)
      for (std::size_t i = 3; i < samples.size(); i += 4)
        samples[i] = std::max<std::uint16_t>(samples[i], 1);
    const Texels picture = decode_texels(make_webp(6, 4, channels, samples), "p.webp");
    EXPECT_EQ(picture.channels, channels);
    expect_same(picture, samples);
  }
  for (const int channels : {1, 3, 4}) {
    for (const bool packed : {false, true}) {
      const Samples samples = ramp(6 * 4 * channels, 255);
      const Texels picture = decode_texels(make_tga(6, 4, channels, samples, packed), "p.tga");
      EXPECT_EQ(picture.channels, channels);
      expect_same(picture, samples);
    }
  }
}

TEST(Texels, hdr_gives_each_mantissa_by_its_exponent) {
  std::vector<std::uint8_t> rgbe;
  for (int i = 0; i < 10 * 2; ++i)
    for (const int value : {i * 11 % 256, 200 - i / 4, 128, i == 3 ? 0 : 120 + i})
      rgbe.push_back(static_cast<std::uint8_t>(value));
  for (const bool packed : {false, true}) {
    const Texels picture = decode_texels(make_hdr(10, 2, rgbe, packed), "p.hdr");
    ASSERT_EQ(picture.width, 10);
    ASSERT_EQ(picture.height, 2);
    ASSERT_EQ(picture.format, TexelFormat::f32);
    const auto found = values_of<float>(picture);
    for (std::size_t i = 0; i < 20; ++i)
      for (std::size_t c = 0; c < 3; ++c) {
        const double expected =
            rgbe[4 * i + 3] == 0 ? 0 : std::ldexp(rgbe[4 * i + c], rgbe[4 * i + 3] - 136);
        ASSERT_EQ(found[3 * i + c], expected) << i;
      }
  }
}

TEST(Texels, exr_keeps_its_depth_and_what_is_no_number_is_tamed) {
  const float infinite = std::numeric_limits<float>::infinity();
  const std::vector<float> planes{0.5F,  1024.25F, -2,           infinite, NAN, 1,
                                  0.25F, 3,        0.000061035F, 7,        8,   9};
  for (const bool halves : {true, false}) {
    const Texels picture = decode_texels(make_exr(2, 2, "RGB", halves, planes), "p.exr");
    ASSERT_EQ(picture.format, halves ? TexelFormat::f16 : TexelFormat::f32);
    ASSERT_EQ(picture.channels, 3);
    const auto found = halves ? values_of<half>(picture) : values_of<float>(picture);
    EXPECT_EQ(found[0], 0.5);
    EXPECT_EQ(found[1], 0);  // NaN
    EXPECT_NEAR(found[2], 0.000061035, 1e-9);
    EXPECT_EQ(found[3], halves ? 1024 : 1024.25);
    EXPECT_NEAR(found[9], halves ? 65504 : 1e30, halves ? 0 : 1e24);
  }
  EXPECT_EQ(decode_texels(make_exr(2, 2, "RGBA", true, std::vector<float>(16)), "p").channels, 4);
  EXPECT_EQ(decode_texels(make_exr(2, 2, "Y", true, std::vector<float>(4)), "p").channels, 1);
  EXPECT_THROW(decode_texels(make_exr(2, 2, "XZ", true, std::vector<float>(8)), "p"), Error);
}

std::vector<std::pair<std::string, File>> one_of_each() {
  std::vector<std::uint8_t> rgbe;
  for (int i = 0; i < 32 * 32 * 4; ++i) rgbe.push_back(static_cast<std::uint8_t>(i * 37 % 251));
  const Samples samples = ramp(32 * 32 * 3, 255);
  return {{"a.png", make_png(32, 32, 8, 2, samples)},
          {"interlaced.png", make_png(32, 32, 16, 2, ramp(32 * 32 * 3, 65535), true)},
          {"a.jpg", make_jpeg(32, 32, 3, samples)},
          {"a.webp", make_webp(32, 32, 3, samples)},
          {"a.tga", make_tga(32, 32, 3, samples, false)},
          {"packed.tga", make_tga(32, 32, 3, samples, true)},
          {"a.hdr", make_hdr(32, 32, rgbe, true)},
          {"old.hdr", make_hdr(32, 32, rgbe, false)},
          {"a.exr", make_exr(32, 32, "RGB", true, std::vector<float>(32 * 32 * 3, 0.3F))}};
}

TEST(Texels, a_file_that_is_cut_short_anywhere_is_an_error_that_names_it) {
  for (const auto& [name, file] : one_of_each()) {
    EXPECT_NO_THROW(decode_texels(file, name)) << name;
    for (std::size_t size = 0; size < file.size(); size += 1 + file.size() / 61) {
      try {
        decode_texels(std::span(file).first(size), name);
        ADD_FAILURE() << name << " cut to " << size << " of " << file.size();
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::bad_input);
        EXPECT_EQ(error.place().file, name);
      }
    }
  }
}

TEST(Texels, a_broken_byte_anywhere_is_an_error_or_a_picture_and_never_more) {
  for (const auto& [name, file] : one_of_each()) {
    for (std::size_t at = 0; at < file.size(); at += 1 + file.size() / 197) {
      File broken = file;
      broken[at] ^= std::byte{0xa5};
      try {
        const Texels picture = decode_texels(broken, name);
        EXPECT_EQ(picture.bytes.size(),
                  picture.row_bytes() * static_cast<std::size_t>(picture.height));
      } catch (const Error& error) {
        EXPECT_EQ(error.place().file, name);
      }
    }
  }
}

void put_big_endian(File& file, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i)
    file[at + i] = static_cast<std::byte>(value >> (24 - 8 * i) & 255U);
}

TEST(Texels, pictures_may_share_a_budget_that_none_exceeds) {
  const std::vector<std::byte> file = make_png(5, 3, 8, 2, Samples(45));
  TexelBudget budget(100);
  EXPECT_NO_THROW(decode_texels(file, "a.png", &budget));
  EXPECT_NO_THROW(decode_texels(file, "b.png", &budget));
  try {
    decode_texels(file, "c.png", &budget);
    FAIL() << "45 bytes of the 10 that are left";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::too_large);
    EXPECT_EQ(error.place().file, "c.png");
  }
}

TEST(Texels, a_picture_that_would_unpack_to_gigabytes_is_refused_by_its_header) {
  const auto refused = [](const File& file, const std::string& name) {
    try {
      decode_texels(file, name);
      ADD_FAILURE() << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::too_large) << error.what();
      EXPECT_EQ(error.place().file, name);
    }
  };
  std::vector<std::uint8_t> rgbe(4 * 8);
  File hdr = make_hdr(8, 1, rgbe, false);
  std::string text(reinterpret_cast<const char*>(hdr.data()), hdr.size());
  text.replace(text.find("-Y 1 +X 8"), 9, "-Y 60000 +X 60000");
  const auto* const bytes = reinterpret_cast<const std::byte*>(text.data());
  refused(File(bytes, bytes + text.size()), "a.hdr");
  // A header alone: 60000 by 60000 of 8 bits, its checksum right.
  File png = make_png(1, 1, 8, 2, {1, 2, 3});
  put_big_endian(png, 16, 60000);
  put_big_endian(png, 20, 60000);
  put_big_endian(png, 29, 0x0fb0e215);
  refused(png, "a.png");
  File jpeg = make_jpeg(8, 8, 1, ramp(64, 255));
  for (std::size_t i = 0; i + 8 < jpeg.size(); ++i) {
    if (jpeg[i] != std::byte{0xff} || jpeg[i + 1] != std::byte{0xc0}) continue;
    for (std::size_t k = 5; k < 9; ++k) jpeg[i + k] = std::byte{0xea};
    break;
  }
  refused(jpeg, "a.jpg");
}

TEST(Texels, what_is_no_picture_is_said_to_be_none) {
  const std::string text = "solid cube, and many more words of it";
  try {
    decode_texels(std::as_bytes(std::span(text)), "cube.stl");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("cube.stl"));
    EXPECT_THAT(error.what(), testing::HasSubstr("WebP"));
  }
}

}  // namespace
}  // namespace tessera::image
