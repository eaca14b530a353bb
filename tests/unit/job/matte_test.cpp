#include "common/job/matte.hpp"

#include <gmock/gmock.h>

#include <array>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/job/matte_pixel.hpp"

namespace tessera {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(Matte, hashes_are_those_that_are_published) {
  // MurmurHash3_x86_32 of seed 0, by every length of the last block.
  EXPECT_EQ(matte_hash(""), 0U);
  EXPECT_EQ(matte_hash("test"), 0xba6bd213U);
  EXPECT_EQ(matte_hash("Hello, world!"), 0xc0363e43U);
  EXPECT_EQ(matte_hash("The quick brown fox jumps over the lazy dog"), 0x2e4ff723U);
  // Of Cryptomatte's documentation and sample pictures: bytes are taken without a sign.
  EXPECT_EQ(matte_hex("bunny"), "13851a76");
  EXPECT_EQ(matte_hex("default"), "42c9679f");
  EXPECT_EQ(matte_hex("uCryptoAsset").substr(0, 7), "d593dd7");
}

std::uint32_t exponent_of(std::uint32_t bits) { return bits >> 23 & 0xffU; }

TEST(Matte, ids_have_the_hashs_bits_but_for_an_exponent_that_no_plain_number_has) {
  int least = 0, most = 0;
  for (int i = 0; i < 5000; ++i) {
    const std::string name = "object " + std::to_string(i);
    const std::uint32_t hash = matte_hash(name);
    const float id = matte_id(name);
    ASSERT_TRUE(std::isnormal(id)) << name;
    const std::uint32_t turned = std::bit_cast<std::uint32_t>(id) ^ hash;
    const bool unusable = exponent_of(hash) == 0 || exponent_of(hash) == 255;
    ASSERT_EQ(turned, unusable ? 0x00800000U : 0U) << name;
    least += exponent_of(hash) == 0 ? 1 : 0;
    most += exponent_of(hash) == 255 ? 1 : 0;
  }
  EXPECT_GT(least, 0);
  EXPECT_GT(most, 0);
}

TEST(MatteNames, go_through_JSON_and_may_not_be_too_long_or_no_text) {
  const MatteNames names{.objects = {"a", "b \"c\""}, .materials = {"ü"}};
  EXPECT_EQ(matte_names_from(to_json(names), "cryptomatte"), names);
  EXPECT_NO_THROW(check(names));
  const MatteNames broken{.objects = {"\xff"}, .materials = {}};
  const MatteNames escaped{.objects = {std::string(20'000, '\x01')}, .materials = {}};
  const MatteNames many{.objects = std::vector<std::string>(10'000, "ten letters"),
                        .materials = {}};
  for (const MatteNames& bad : {broken, escaped, many}) {
    EXPECT_FALSE(can_travel(bad));
    EXPECT_THROW(check(bad), Error);
  }
}

using Channels = std::array<double, matte_channels>;

Channels written(MattePixel& pixel) {
  Channels out;
  out.fill(-1);
  pixel.write(out);
  return out;
}

TEST(MattePixel, counts_each_id_and_writes_the_heaviest_first) {
  MattePixel pixel;
  for (const double id : {-2.5, 7.0, 7.0, 0.0, 3.0, 7.0, -2.5, 4.0}) pixel.add(id, 1);
  const Channels channels = written(pixel);
  EXPECT_THAT(std::vector<double>(channels.begin(), channels.begin() + 10),
              ElementsAre(7, 3, -2.5, 2, 3, 1, 4, 1, 0, 0));
  EXPECT_EQ(channels.back(), 0);
  pixel.clear();
  EXPECT_EQ(written(pixel), Channels{});
}

TEST(MattePixel, sums_what_channels_say_in_any_order) {
  Channels one{}, other{};
  one[0] = 5, one[1] = 3, one[2] = 6, one[3] = 1, one.back() = 2;
  other[0] = 6, other[1] = 2, other[2] = 9, other[3] = 1, other.back() = 1;
  MattePixel pixel, turned;
  for (const Channels& channels : {one, other}) pixel.add(channels);
  for (const Channels& channels : {other, one}) turned.add(channels);
  const Channels sum = written(pixel);
  EXPECT_EQ(sum, written(turned));
  EXPECT_THAT(std::vector<double>(sum.begin(), sum.begin() + 6), ElementsAre(5, 3, 6, 3, 9, 1));
  EXPECT_EQ(sum.back(), 3);
}

TEST(MattePixel, evicts_the_lightest_beyond_its_slots_and_counts_them) {
  MattePixel pixel;
  for (int id = 1; id <= 20; ++id) pixel.add(id, id <= 3 ? 1 : 2);
  const Channels channels = written(pixel);
  double kept = 0;
  for (std::size_t slot = 0; slot < matte_slots; ++slot) {
    EXPECT_EQ(channels[2 * slot], static_cast<double>(4 + slot));
    kept += channels[2 * slot + 1];
  }
  EXPECT_EQ(kept, 32);
  EXPECT_EQ(channels.back(), 5);  // three of 1, and one of 2: the highest id
}

}  // namespace
}  // namespace tessera
