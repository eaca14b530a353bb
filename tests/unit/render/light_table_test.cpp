#include "worker/render/lights/light_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "tests/unit/render/chi2.hpp"

namespace tessera::render {
namespace {

Light sphere(float x, float radiance) {
  return {.shape = SphereLight{{x, 0, 3}, 0.5F}, .radiance = gray(radiance)};
}

TEST(LightTable, ChoosesByPowerAndSaysHowOften) {
  std::vector<Light> lights;
  lights.reserve(37);
  for (int i = 0; i < 37; ++i)
    lights.push_back(sphere(static_cast<float>(i), static_cast<float>(i % 7)));
  const LightTable table(lights);
  double total = 0;
  for (const Light& light : lights) total += static_cast<double>(luminance(power(light)));
  std::vector<double> observed(lights.size(), 0.0), expected;
  expected.reserve(lights.size());
  constexpr int n = 200'000;
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    const double share = static_cast<double>(luminance(power(table[i]))) / total;
    EXPECT_NEAR(static_cast<double>(table.pmf(i)), share, 1e-7);
    expected.push_back(share * n);
  }
  test::Random random(2);
  for (int i = 0; i < n; ++i) {
    const LightTable::Pick pick = table.pick(random.bits());
    observed[pick.light] += 1;
    EXPECT_EQ(pick.pmf, table.pmf(pick.light));
    EXPECT_GT(pick.pmf, 0);
  }
  EXPECT_EQ(test::chi2_compare(observed, expected), "");
}

TEST(LightTable, EachOfManyLightsIsChosenAsOftenAsItsPmfSays) {
  // Every 512th of all 2^32 numbers: each light's frequency, to the grid's step.
  std::vector<Light> lights;
  lights.reserve(3000);
  for (int i = 0; i < 3000; ++i) lights.push_back(sphere(0, 1 + static_cast<float>(i % 11)));
  const LightTable table(lights);
  std::vector<double> count(lights.size(), 0.0);
  constexpr std::uint64_t step = 512, numbers = (1ULL << 32) / step;
  for (std::uint64_t i = 0; i < numbers; ++i) {
    count[table.pick(static_cast<std::uint32_t>(i * step)).light] += 1;
  }
  double pmf_sum = 0;
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    const double frequency = count[i] / static_cast<double>(numbers);
    EXPECT_NEAR(frequency / static_cast<double>(table.pmf(i)), 1, 5e-3) << i;
    pmf_sum += static_cast<double>(table.pmf(i));
  }
  EXPECT_NEAR(pmf_sum, 1, 1e-5);
}

TEST(LightTable, ALightWithoutPowerIsNeverChosen) {
  const LightTable table({sphere(0, 0), sphere(1, 1), sphere(2, 0), sphere(3, 1e-6F)});
  EXPECT_EQ(table.pmf(0), 0);
  EXPECT_EQ(table.pmf(2), 0);
  test::Random random(1);
  for (int i = 0; i < 100'000; ++i) {
    const std::uint32_t light = table.pick(random.bits()).light;
    EXPECT_TRUE(light == 1 || light == 3);
  }
  for (const std::uint32_t bits : {0U, 0x3fffffffU, 0x40000000U, 0x7fffffffU, 0xffffffffU}) {
    EXPECT_GT(table.pick(bits).pmf, 0);
  }
}

TEST(LightTable, NoLightsOrNoPowerChoosesNone) {
  EXPECT_EQ(LightTable().pick(5).pmf, 0);
  EXPECT_TRUE(LightTable().empty());
  const LightTable dark({sphere(0, 0)});
  EXPECT_EQ(dark.pick(5).pmf, 0);
  EXPECT_FALSE(static_cast<bool>(dark.sample({}, 5, {0.5F, 0.5F})));
  EXPECT_EQ(dark.pdf({}, 0, {.wi = {0, 0, 1}, .distance = 2}), 0);
}

TEST(LightTable, TheEnvironmentIsChosenAsOftenAsAllOthersHoweverFarTheSceneReaches) {
  for (const float reach : {1e-3F, 1.0F, 1e6F}) {
    const LightTable table(
        {sphere(0, 1), {.shape = EnvironmentLight{{}, reach}, .radiance = gray(1)}, sphere(5, 3)});
    EXPECT_NEAR(table.pmf(1), 0.5, 1e-6) << reach;
    EXPECT_NEAR(table.pmf(0), 0.125, 1e-6) << reach;
    EXPECT_NEAR(table.pmf(2), 0.375, 1e-6) << reach;
  }
  const LightTable alone({{.shape = EnvironmentLight{{}, 2}, .radiance = gray(1)}, sphere(0, 0)});
  EXPECT_EQ(alone.pmf(0), 1);
  EXPECT_EQ(alone.pmf(1), 0);
}

TEST(LightTable, ASampleHoldsTheChoiceAndTheLightsNames) {
  Light named = sphere(0, 4);
  named.instance = 7;
  named.primitive = 9;
  const LightTable table(
      {named, sphere(5, 1), {.shape = EnvironmentLight{{}, 2}, .radiance = gray(0.1F)}});
  EXPECT_EQ(table.environment(), 2U);
  test::Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const std::uint32_t bits = random.bits();
    const LightSample drawn = table.sample({}, bits, random.next2());
    ASSERT_TRUE(static_cast<bool>(drawn));
    EXPECT_EQ(drawn.light, table.pick(bits).light);
    const LightHit hit{.wi = drawn.wi, .distance = drawn.distance};
    EXPECT_NEAR(table.pdf({}, drawn.light, hit) / drawn.pdf, 1, 1e-5F);
    EXPECT_FLOAT_EQ(table.pdf({}, drawn.light, hit),
                    table.pmf(drawn.light) * pdf(table[drawn.light], {}, hit));
    EXPECT_EQ(drawn.radiance, table[drawn.light].radiance);
    if (drawn.light == 0) {
      EXPECT_EQ(drawn.instance, 7U);
      EXPECT_EQ(drawn.primitive, 9U);
    }
  }
}

}  // namespace
}  // namespace tessera::render
