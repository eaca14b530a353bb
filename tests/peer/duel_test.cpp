#include "tests/peer/duel.hpp"

#include <gmock/gmock.h>

#include <random>

#include "common/base/error.hpp"

namespace tessera::peer {
namespace {

constexpr int width = 64, height = 48, pictures = 16;

/// Pictures of one mean with so much noise, independent from pixel to pixel and seed to seed.
std::vector<report::Picture> noisy(double mean, double noise, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> value(mean, noise);
  std::vector<report::Picture> out(pictures);
  for (report::Picture& picture : out) {
    picture.width = width;
    picture.height = height;
    for (std::vector<float>& plane : picture.rgb) {
      plane.resize(static_cast<std::size_t>(width * height));
      for (float& at : plane) at = static_cast<float>(value(random));
    }
  }
  return out;
}

TEST(Duel, errors_are_those_of_each_renderers_own_noise) {
  const Duel duel = compare(noisy(0.5, 0.02, 1), noisy(0.5, 0.1, 2));
  const double below = 0.5 * 0.5 + 0.01;
  // The reference's noise adds a fifteenth to the less noisy one, at most.
  EXPECT_NEAR(duel.first.relative / (0.02 * 0.02 / below), 1 + 1.0 / 16, 0.03);
  EXPECT_NEAR(duel.second.relative / (0.1 * 0.1 / below), 1, 0.03);
  EXPECT_LT(duel.second.trimmed, duel.second.relative);
}

TEST(Duel, renderers_that_agree_differ_as_often_as_the_level_says) {
  const Duel duel = compare(noisy(0.5, 0.02, 3), noisy(0.5, 0.1, 4));
  // 9,216 tests at .001: 9.2 ± 3.
  EXPECT_LT(duel.beyond.pixels, 0.0025);
  EXPECT_GT(duel.beyond.pixels, 0.0001);
  for (const report::WelchTest& test : duel.means) EXPECT_GT(test.p, 0.001);
}

TEST(Duel, a_bias_far_below_a_pixels_noise_is_seen_in_blocks_and_in_the_mean) {
  const Duel duel = compare(noisy(0.5, 0.05, 5), noisy(0.51, 0.05, 6));
  EXPECT_GT(duel.beyond.blocks, 0.5);
  for (const report::WelchTest& test : duel.means) EXPECT_LT(test.p, 1e-6);
}

TEST(Duel, a_place_that_one_shows_otherwise_is_seen_among_the_pixels) {
  const std::vector<report::Picture> first = noisy(0.5, 0.02, 7);
  std::vector<report::Picture> second = noisy(0.5, 0.02, 8);
  const int changed = width * height / 10;
  for (report::Picture& picture : second)
    for (std::vector<float>& plane : picture.rgb)
      for (int i = 0; i < changed; ++i) plane[static_cast<std::size_t>(i)] += 0.2F;
  EXPECT_NEAR(compare(first, second).beyond.pixels, 0.1, 0.003);
}

TEST(Duel, of_pictures_without_noise_tells_those_apart_that_differ) {
  EXPECT_EQ(compare(noisy(0.5, 0, 1), noisy(0.5, 0, 2)).beyond.pixels, 0);
  EXPECT_EQ(compare(noisy(0.5, 0, 1), noisy(0.6, 0, 2)).beyond.pixels, 1);
}

TEST(Duel, refuses_too_few_pictures_and_pictures_of_another_size) {
  EXPECT_THROW(compare({}, noisy(0.5, 0, 1)), Error);
  std::vector<report::Picture> other = noisy(0.5, 0, 1);
  other[3].width = height;
  EXPECT_THROW(compare(noisy(0.5, 0, 1), other), Error);
}

}  // namespace
}  // namespace tessera::peer
