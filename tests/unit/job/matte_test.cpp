#include "common/job/matte.hpp"

#include <gmock/gmock.h>

#include <array>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
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
    EXPECT_FALSE(can_stand(bad));
    EXPECT_THROW(check(bad), Error);
  }
}

std::size_t bytes_of(const MatteNames& names) { return to_json(names).dump().size(); }

/// Of so many bytes as JSON, with quotes that are escaped and a comma between each two of them.
std::vector<std::string> names_of(std::size_t bytes) {
  std::vector<std::string> out{"\"quoted\"", "a\nb"};
  const auto lacking = [&] { return bytes - bytes_of({.objects = out, .materials = {}}); };
  while (lacking() > 1000) out.emplace_back(500, 'x');
  out.emplace_back(lacking() - 3, 'y');
  return out;
}

TEST(MatteNames, are_counted_to_the_byte_that_their_JSON_has) {
  const MatteNames full{.objects = names_of(limits::matte_names_bytes), .materials = {}};
  ASSERT_EQ(bytes_of(full), limits::matte_names_bytes);
  EXPECT_TRUE(can_stand(full));
  EXPECT_TRUE(fitting(full).left_out.empty());
  MatteNames more = full;
  more.objects.back() += 'z';
  EXPECT_FALSE(can_stand(more));
  EXPECT_TRUE(fitting(more).names.empty());
  // Names alone are less than that by far; what stands around them counts.
  const MatteNames short_ones{
      .objects = std::vector<std::string>(limits::matte_names_bytes / 3, ""), .materials = {}};
  EXPECT_FALSE(can_stand(short_ones));
}

TEST(MatteNames, that_do_not_fit_leave_out_objects_first_and_say_so) {
  const std::vector<std::string> few{"a", "b"}, half = names_of(limits::matte_names_bytes / 2 + 10),
                                                far = names_of(2 * limits::matte_names_bytes);
  const auto fit = [](const std::vector<std::string>& objects,
                      const std::vector<std::string>& materials) {
    return fitting({.objects = objects, .materials = materials});
  };
  const FittingNames both = fit(few, half);
  EXPECT_EQ(both.names, (MatteNames{few, half}));
  EXPECT_TRUE(both.left_out.empty());
  for (const auto& objects : {half, far}) {
    const FittingNames some = fit(objects, half);
    EXPECT_EQ(some.names, (MatteNames{{}, half}));
    const std::string why = objects == half ? "those of materials together" : "its names are";
    EXPECT_THAT(some.left_out, ElementsAre(testing::AllOf(HasSubstr("CryptoObject"),
                                                          HasSubstr("96 KiB"), HasSubstr(why))));
  }
  const FittingNames objects = fit(few, far);
  EXPECT_EQ(objects.names, (MatteNames{few, {}}));
  EXPECT_THAT(objects.left_out, ElementsAre(HasSubstr("CryptoMaterial")));
  EXPECT_EQ(fit(far, far).left_out.size(), 2U);
  EXPECT_TRUE(fit(far, far).names.empty());
  const FittingNames broken = fit({"\xff"}, few);
  EXPECT_EQ(broken.names, (MatteNames{{}, few}));
  EXPECT_THAT(broken.left_out, ElementsAre(HasSubstr("UTF-8")));
}

TEST(MatteNames, of_mattes_that_are_asked_for_alone_are_missed) {
  const MatteNames names{.objects = {"a"}, .materials = {}};
  const std::vector<std::string> both{"CryptoMaterial", "N", "CryptoObject"},
      objects{"CryptoObject"}, none{"N"};
  EXPECT_THAT(mattes_without_names(both, names), ElementsAre("CryptoMaterial"));
  EXPECT_THAT(mattes_without_names(both, {}), ElementsAre("CryptoObject", "CryptoMaterial"));
  EXPECT_TRUE(mattes_without_names(objects, names).empty());
  EXPECT_TRUE(mattes_without_names(none, {}).empty());
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
