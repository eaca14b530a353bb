#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>

#include "common/base/error.hpp"
#include "common/image/tile.hpp"
#include "tests/unit/image/make_tile.hpp"

/// What a broken or malicious worker may send instead of a tile.
namespace tessera::image {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using Bytes = std::vector<std::byte>;

/// What decode_tile says, empty if it takes the bytes. Anything but Error{bad_input} fails the
/// test.
std::string refusal(const Bytes& exr, const TileExpectation& expected) {
  try {
    const TileImage tile = decode_tile(exr, expected);
    EXPECT_EQ(tile.values.size(), tile.channels() * tile.pixels());
    EXPECT_TRUE(std::ranges::all_of(tile.values, [](float value) { return std::isfinite(value); }));
    EXPECT_TRUE(std::ranges::all_of(tile.plane(M2_R), [](float value) { return value >= 0; }));
    return {};
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::bad_input) << error.what();
    return error.what();
  }
}

class HostileTile : public testing::Test {
 protected:
  TileImage tile = make_tile({3, 5, 4, 3}, 16, 12, 4, true);
  TileExpectation expected = expectation_of(tile);
  Bytes exr = encode_tile(tile);

  /// Where an attribute's value begins: behind its name, type and length.
  [[nodiscard]] std::size_t value_of(const std::string& name, const std::string& type) const {
    const std::string key = name + '\0' + type + '\0';
    const auto raw = std::as_bytes(std::span(key));
    const auto found = std::search(exr.begin(), exr.end(), raw.begin(), raw.end());
    EXPECT_NE(found, exr.end()) << name;
    return static_cast<std::size_t>(found - exr.begin()) + key.size() + 4;
  }
  template <class T>
  void put(std::size_t at, T value) {
    ASSERT_LE(at + sizeof value, exr.size());
    std::memcpy(exr.data() + at, &value, sizeof value);
  }
};

TEST_F(HostileTile, is_taken_as_long_as_nobody_touched_it) {
  EXPECT_EQ(refusal(exr, expected), "");
}

TEST_F(HostileTile, truncated_anywhere_is_refused) {
  for (std::size_t length = 0; length < exr.size(); ++length)
    EXPECT_NE(
        refusal(Bytes(exr.begin(), exr.begin() + static_cast<std::ptrdiff_t>(length)), expected),
        "")
        << length;
}

TEST_F(HostileTile, with_any_word_replaced_never_crashes_and_is_refused_or_has_lawful_values) {
  const Bytes whole = exr;
  for (std::size_t at = 0; at + 4 <= whole.size(); ++at)
    for (const std::uint32_t word : {0U, 1U, 0x7fffffffU, 0x80000000U, 0xffffffffU, 0x00010000U}) {
      exr = whole;
      put(at, word);
      refusal(exr, expected);
    }
}

TEST_F(HostileTile, with_random_bytes_replaced_never_crashes_and_is_refused_or_has_lawful_values) {
  const Bytes whole = exr;
  std::mt19937 random(99);
  std::size_t refused = 0;
  for (int round = 0; round < 20'000; ++round) {
    exr = whole;
    const auto flips = 1 + random() % 8;
    for (std::size_t i = 0; i < flips; ++i)
      exr[random() % exr.size()] = static_cast<std::byte>(random());
    refused += refusal(exr, expected).empty() ? 0 : 1;
  }
  EXPECT_GT(refused, 1000U);
}

TEST_F(HostileTile, of_random_bytes_is_refused_by_its_magic_number) {
  EXPECT_THAT(refusal(Bytes(4096, std::byte{0x5a}), expected),
              HasSubstr("magic number: expected that of an EXR file, found 0x5a5a5a5a"));
  EXPECT_THAT(refusal({}, expected), HasSubstr("size: expected an EXR file, found 0 bytes"));
}

TEST_F(HostileTile, of_another_kind_of_file_is_refused_by_name) {
  for (const auto& [flags, name] :
       {std::pair(0x202U, "tiled"), std::pair(0x802U, "deep"), std::pair(0x1002U, "several parts"),
        std::pair(0x402U, "long names"), std::pair(0x3U, "version 3")}) {
    put(4, flags);
    EXPECT_THAT(refusal(exr, expected),
                AllOf(HasSubstr("expected version 2, one part of scan lines"), HasSubstr(name)));
  }
}

TEST_F(HostileTile, of_another_size_is_refused_with_both_windows) {
  const Bytes other = encode_tile(make_tile({3, 5, 5, 3}, 16, 12, 4, true));
  EXPECT_THAT(refusal(other, expected),
              HasSubstr("data window: expected 4x3 at 3,5, found 5x3 at 3,5"));
  const Bytes elsewhere = encode_tile(make_tile({4, 5, 4, 3}, 16, 12, 4, true));
  EXPECT_THAT(refusal(elsewhere, expected), HasSubstr("expected 4x3 at 3,5, found 4x3 at 4,5"));
  const Bytes film = encode_tile(make_tile({3, 5, 4, 3}, 17, 12, 4, true));
  EXPECT_THAT(refusal(film, expected),
              HasSubstr("display window: expected 16x12 at 0,0, found 17x12 at 0,0"));
}

TEST_F(HostileTile, that_says_it_is_huge_is_refused_before_anything_is_allocated_by_it) {
  const std::size_t window = value_of("dataWindow", "box2i");
  put(window + 8, std::int32_t{60'002});
  put(window + 12, std::int32_t{60'004});
  EXPECT_THAT(refusal(exr, expected),
              HasSubstr("data window: expected 4x3 at 3,5, found 60000x60000 at 3,5"));
  put(window, std::numeric_limits<std::int32_t>::min());
  put(window + 4, std::numeric_limits<std::int32_t>::min());
  put(window + 8, std::numeric_limits<std::int32_t>::max());
  put(window + 12, std::numeric_limits<std::int32_t>::max());
  EXPECT_THAT(refusal(exr, expected), HasSubstr("not a valid EXR file"));
}

TEST_F(HostileTile, that_is_much_longer_than_its_pixels_is_refused) {
  exr.resize(exr.size() + 200'000);
  EXPECT_THAT(refusal(exr, expected),
              AllOf(HasSubstr("size: expected at most"), HasSubstr("found 2014")));
}

TEST_F(HostileTile, with_other_channels_is_refused_with_both_lists) {
  const Bytes beauty = encode_tile(make_tile({3, 5, 4, 3}, 16, 12, 4, false));
  EXPECT_THAT(
      refusal(beauty, expected),
      AllOf(
          HasSubstr(
              "channels: expected A B G M2.B M2.G M2.R N.X N.Y N.Z R Z albedo.B albedo.G albedo.R"),
          HasSubstr("found A (float) B (float) G (float) M2.B (float) M2.G (float) M2.R (float) R "
                    "(float)")));
  TileExpectation no_aovs = expected;
  no_aovs.aovs = false;
  EXPECT_NE(refusal(exr, no_aovs), "");
}

TEST_F(HostileTile, with_a_channel_of_another_name_type_or_grid_is_refused) {
  const Bytes whole = exr;
  const std::size_t first = value_of("channels", "chlist");
  put(first + 2, std::int32_t{1});
  EXPECT_THAT(refusal(exr, expected), HasSubstr("A (half)"));
  exr = whole;
  put(first, 'C');
  EXPECT_NE(refusal(exr, expected), "");
  exr = whole;
  put(first + 10, std::int32_t{2});
  EXPECT_NE(refusal(exr, expected), "");
  exr = whole;
  put(first, '\x1b');
  EXPECT_THAT(refusal(exr, expected), testing::Not(HasSubstr("\x1b")));
}

TEST_F(HostileTile, that_is_compressed_is_refused) {
  put(value_of("compression", "compression"), std::uint8_t{3});
  EXPECT_THAT(refusal(exr, expected), HasSubstr("compression: expected none, found method 3"));
}

TEST_F(HostileTile, with_another_sample_count_is_refused_with_both_numbers) {
  TileExpectation other = expected;
  other.samples = 12;
  EXPECT_THAT(refusal(exr, other), HasSubstr("tessera.samples.beauty: expected 12, found 4"));
  const std::size_t count = value_of("tessera.samples.aov", "int");
  put(count, std::int32_t{-4});
  EXPECT_THAT(refusal(exr, expected), HasSubstr("tessera.samples.aov: expected 4, found -4"));
}

TEST_F(HostileTile, without_a_sample_count_or_with_one_of_another_type_is_refused) {
  const Bytes whole = exr;
  const std::size_t value = value_of("tessera.samples.beauty", "int");
  put(value - 4 - 4 - 1, 'X');  // the name's last letter
  EXPECT_THAT(refusal(exr, expected),
              HasSubstr("tessera.samples.beauty: expected 4, found nothing"));
  exr = whole;
  std::memcpy(exr.data() + value - 4 - 4, "abc", 3);
  EXPECT_THAT(refusal(exr, expected),
              HasSubstr("tessera.samples.beauty: expected 4, found another type than int"));
}

TEST_F(HostileTile, with_a_value_that_is_no_number_is_refused_by_channel_and_pixel) {
  const TileImage whole = tile;
  const float inf = std::numeric_limits<float>::infinity(),
              nan = std::numeric_limits<float>::quiet_NaN();
  for (const float bad : {nan, -nan, inf, -inf}) {
    tile = whole;
    tile.plane(albedo_G)[4 + 2] = bad;
    EXPECT_THAT(refusal(encode_tile(tile), expected),
                AllOf(HasSubstr("channel albedo.G at pixel 5,6: expected a finite number, found"),
                      HasSubstr(bad == inf || bad == -inf ? "inf" : "nan")));
  }
}

TEST_F(HostileTile, with_a_negative_second_moment_is_refused_and_a_negative_colour_is_not) {
  tile.plane(R)[0] = -1;
  tile.plane(M2_G)[1] = -0.0F;
  EXPECT_EQ(refusal(encode_tile(tile), expected), "");
  tile.plane(M2_G)[0] = -1e-20F;
  EXPECT_THAT(
      refusal(encode_tile(tile), expected),
      HasSubstr("channel M2.G at pixel 3,5: expected a finite number, not negative, found -1e-20"));
}

TEST_F(HostileTile, whose_lines_are_not_where_the_table_says_is_refused) {
  const Bytes whole = exr;
  const std::size_t pixels_at = exr.size() - 3 * (8 + 14 * 4 * 4);
  put(pixels_at - 8, std::uint64_t{1} << 40);  // the last line's offset
  EXPECT_NE(refusal(exr, expected), "");
  exr = whole;
  put(pixels_at, std::int32_t{6});  // the first line says it is the second
  EXPECT_NE(refusal(exr, expected), "");
  exr = whole;
  put(pixels_at + 4, std::int32_t{100});  // and has another length
  EXPECT_NE(refusal(exr, expected), "");
}

}  // namespace
}  // namespace tessera::image
