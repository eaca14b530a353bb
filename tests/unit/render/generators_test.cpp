#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "tests/unit/render/chi2.hpp"
#include "worker/render/sampler.hpp"
#include "worker/render/sampler_mt19937.hpp"
#include "worker/render/sampler_pcg.hpp"
#include "worker/render/sampler_xorshift.hpp"

/// The generators against what their authors print, and the samplers that are made of them.
namespace tessera::render {
namespace {

using testing::ElementsAre;

template <class Generator>
std::vector<std::uint32_t> first(Generator generator, int count) {
  std::vector<std::uint32_t> numbers;
  for (int i = 0; i < count; ++i) numbers.push_back(static_cast<std::uint32_t>(generator()));
  return numbers;
}

TEST(Generators, TheMersenneTwisterGivesItsAuthorsNumbers) {
  EXPECT_THAT(first(std::mt19937(5489), 4),
              ElementsAre(3499211612U, 581869302U, 3890346734U, 3586334585U));
  std::mt19937 generator;
  generator.discard(9999);
  EXPECT_EQ(generator(), 4123659995U) << "what the C++ standard asks of the 10000th";
}

TEST(Generators, XorshiftGivesWhatThePapersCodeGives) {
  // xor128() of section 4, its seeds as printed.
  EXPECT_THAT(first(Xorshift128(), 5),
              ElementsAre(3701687786U, 458299110U, 2500872618U, 3633119408U, 516391518U));
}

TEST(Generators, XorshiftNeverStandsAtZero) {
  EXPECT_EQ(first(Xorshift128(0, 0), 8), first(Xorshift128(), 8));
  EXPECT_THAT(first(Xorshift128(1, 0), 8), testing::Contains(testing::Ne(0U)));
}

TEST(Generators, PcgGivesTheNumbersOfItsDemo) {
  // pcg32-demo of the paper's library: pcg32_srandom(42, 54), its first round.
  EXPECT_THAT(first(Pcg32(42, 54), 6), ElementsAre(0xa15c02b7U, 0x7b47f409U, 0xba1d3330U,
                                                   0x83d2f293U, 0xbfa4784bU, 0xcbed606eU));
}

TEST(Generators, AnAddressIsTheStartOfAStream) {
  const std::uint64_t pixel = 99, index = 1'000'000'007;
  const std::uint32_t set = 5;
  const std::uint64_t key = draw_key(pixel, set, index);
  std::array<std::uint32_t, 4> drawn = mt19937_draw(pixel, set, index);
  EXPECT_THAT(first(std::mt19937(static_cast<std::uint32_t>(key >> 32)), 4),
              testing::ElementsAreArray(drawn));
  drawn = pcg_draw(pixel, set, index);
  EXPECT_THAT(first(Pcg32(key, set), 4), testing::ElementsAreArray(drawn));
  drawn = xorshift_draw(pixel, set, index);
  EXPECT_THAT(
      first(Xorshift128(mix64(key + 0x9e3779b97f4a7c15ULL), mix64(key + 2 * 0x9e3779b97f4a7c15ULL)),
            4),
      testing::ElementsAreArray(drawn));
}

class PlainSampler : public testing::TestWithParam<std::string_view> {
 protected:
  [[nodiscard]] static SamplerKind kind() { return sampler_kind(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(Names, PlainSampler,
                         testing::Values("independent", "pcg", "xorshift", "mt19937"),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(PlainSampler, NumbersOfOnePixelAreUniform) {
  for (std::uint32_t place = 0; place < 4; ++place) {
    std::vector<double> observed(256, 0.0);
    for (std::uint64_t i = 0; i < 25'600; ++i) {
      const std::uint32_t bits = Sampler(kind(), 3, 12, 34, i).draw4(dim::bsdf_set(0)).bits(place);
      observed[bits >> 24] += 1;
    }
    EXPECT_EQ(test::chi2_compare(observed, std::vector<double>(256, 100.0)), "") << place;
  }
}

TEST_P(PlainSampler, LowBitsAreUniformToo) {
  // The light's choice takes all 32.
  std::vector<double> observed(256, 0.0);
  for (std::uint64_t i = 0; i < 25'600; ++i) {
    observed[Sampler(kind(), 4, 1, 2, i).draw4(dim::light_set(0)).bits(2) & 255] += 1;
  }
  EXPECT_EQ(test::chi2_compare(observed, std::vector<double>(256, 100.0)), "");
}

TEST_P(PlainSampler, OneNumberSaysNothingOfTheNext) {
  // Of one draw, and of the same place in the next sample's.
  for (std::uint32_t place = 0; place < 4; ++place) {
    std::vector<double> within(256, 0.0), across(256, 0.0);
    for (std::uint64_t i = 0; i < 25'600; ++i) {
      const Draw4 draw = Sampler(kind(), 3, 7, 7, i).draw4(dim::bsdf_set(1));
      const Draw4 next = Sampler(kind(), 3, 7, 7, i + 1).draw4(dim::bsdf_set(1));
      const std::uint32_t row = draw.bits(place) >> 28 << 4;
      within[row | draw.bits((place + 1) % 4) >> 28] += 1;
      across[row | next.bits(place) >> 28] += 1;
    }
    EXPECT_EQ(test::chi2_compare(within, std::vector<double>(256, 100.0)), "") << place;
    EXPECT_EQ(test::chi2_compare(across, std::vector<double>(256, 100.0)), "") << place;
  }
}

}  // namespace
}  // namespace tessera::render
