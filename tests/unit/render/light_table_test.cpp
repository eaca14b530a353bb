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

/// Where nothing is behind the surface, as there is none.
const LightContext here{};

TEST(LightTable, AskedForItChoosesByPowerWherever) {
  std::vector<Light> lights;
  lights.reserve(37);
  for (int i = 0; i < 37; ++i)
    lights.push_back(sphere(static_cast<float>(i), static_cast<float>(i % 7)));
  const LightTable table(lights, LightTable::Choice::by_power);
  double total = 0;
  for (const Light& light : lights) total += static_cast<double>(luminance(power(light)));
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    const double share = static_cast<double>(luminance(power(table[i]))) / total;
    EXPECT_NEAR(static_cast<double>(table.pmf(here, i)), share, 1e-7);
    EXPECT_EQ(table.pmf(here, i), table.pmf({.p = {30, 1, 2}, .n = {0, 0, 1}}, i));
  }
  const LightTable::Pick pick = table.pick(here, 0x12345678);
  EXPECT_EQ(pick.pmf, table.pmf(here, pick.light));
}

TEST(LightTable, ChoosesAmongNearAndFarAsOftenAsItSays) {
  std::vector<Light> lights;
  for (int i = 0; i < 20; ++i)
    lights.push_back(sphere(static_cast<float>(i - 10), static_cast<float>(i % 5)));
  lights.push_back({.shape = EnvironmentLight{{}, 1e6F}, .radiance = gray(1)});
  lights.push_back({.shape = DirectionalLight{}, .radiance = gray(40)});
  lights.push_back({.shape = PointLight{{1, 2, 3}}, .radiance = gray(2)});
  lights.push_back({.shape = DirectionalLight{}, .radiance = gray(0)});
  const LightTable table(lights);
  constexpr int n = 400'000;
  for (const LightContext& context :
       {here, LightContext{.p = {2, 0, 1}, .n = {0, 0, 1}}, LightContext{.p = {-9, 0.1F, 3}},
        LightContext{.p = {0, 0, 9}, .n = {0, 0, 1}}}) {
    std::vector<double> observed(lights.size() + 1, 0.0), expected;
    for (std::uint32_t i = 0; i < table.size(); ++i)
      expected.push_back(n * static_cast<double>(table.pmf(context, i)));
    const double chosen = std::accumulate(expected.begin(), expected.end(), 0.0);
    EXPECT_NEAR(chosen, n, 1e-5 * n);
    expected.push_back(std::max(0.0, n - chosen));
    test::Random random(2);
    for (int i = 0; i < n; ++i) {
      const LightTable::Pick pick = table.pick(context, random.bits());
      observed[pick.pmf > 0 ? pick.light : lights.size()] += 1;
      if (!(pick.pmf > 0)) continue;
      ASSERT_EQ(pick.pmf, table.pmf(context, pick.light));
    }
    EXPECT_EQ(test::chi2_compare(observed, expected), "");
  }
}

TEST(LightTable, ALightWithoutPowerIsNeverChosen) {
  const LightTable table({sphere(0, 0), sphere(1, 1), sphere(2, 0), sphere(3, 1e-6F)});
  EXPECT_EQ(table.pmf(here, 0), 0);
  EXPECT_EQ(table.pmf(here, 2), 0);
  test::Random random(1);
  for (int i = 0; i < 100'000; ++i) {
    const std::uint32_t light = table.pick(here, random.bits()).light;
    EXPECT_TRUE(light == 1 || light == 3);
  }
  for (const std::uint32_t bits : {0U, 0x3fffffffU, 0x40000000U, 0x7fffffffU, 0xffffffffU}) {
    EXPECT_GT(table.pick(here, bits).pmf, 0);
  }
}

TEST(LightTable, NoLightsOrNoPowerChoosesNone) {
  EXPECT_EQ(LightTable().pick(here, 5).pmf, 0);
  EXPECT_TRUE(LightTable().empty());
  for (const auto choice : {LightTable::Choice::by_importance, LightTable::Choice::by_power}) {
    const LightTable dark({sphere(0, 0)}, choice);
    EXPECT_EQ(dark.pick(here, 5).pmf, 0);
    EXPECT_FALSE(static_cast<bool>(dark.sample({}, 5, {0.5F, 0.5F})));
    EXPECT_EQ(dark.pdf({}, 0, {.wi = {0, 0, 1}, .distance = 2}), 0);
  }
}

TEST(LightTable, HowFarTheSceneReachesChangesNoChoice) {
  for (const float reach : {1e-3F, 1.0F, 1e6F}) {
    const LightTable table({sphere(0, 1),
                            {.shape = EnvironmentLight{{}, reach}, .radiance = gray(1)},
                            {.shape = DirectionalLight{.radius = reach}, .radiance = gray(pi)}});
    EXPECT_NEAR(table.pmf(here, 0), 0.5, 1e-6) << reach;
    EXPECT_NEAR(table.pmf(here, 1), 0.25, 1e-6) << reach;
    EXPECT_NEAR(table.pmf(here, 2), 0.25, 1e-6) << reach;
  }
}

TEST(LightTable, ABrightSunLeavesTheSkyItsPartAndOthersThatAreBehindLeaveAll) {
  const LightTable table({sphere(0, 1),
                          {.shape = EnvironmentLight{}, .radiance = gray(1)},
                          {.shape = DirectionalLight{}, .radiance = gray(1e6F)}});
  EXPECT_NEAR(table.pmf(here, 1), 0.125, 1e-5);
  // The sphere is behind this surface.
  const LightContext away{.p = {0, 0, 9}, .n = {0, 0, 1}};
  EXPECT_EQ(table.pmf(away, 0), 0);
  EXPECT_NEAR(table.pmf(away, 1), 0.25, 1e-5);
  EXPECT_NEAR(table.pmf(away, 2), 0.75, 1e-5);
}

TEST(LightTable, ASampleHoldsTheChoiceAndTheLightsNames) {
  Light named = sphere(0, 4);
  named.instance = 7;
  named.primitive = 9;
  const LightTable table(
      {named, sphere(5, 1), {.shape = EnvironmentLight{{}, 2}, .radiance = gray(0.1F)}});
  EXPECT_EQ(table.seen_far(), std::vector<std::uint32_t>(1, 2U));
  test::Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const std::uint32_t bits = random.bits();
    const LightSample drawn = table.sample({}, bits, random.next2());
    ASSERT_TRUE(static_cast<bool>(drawn));
    EXPECT_EQ(drawn.light, table.pick({}, bits).light);
    const LightHit hit{.wi = drawn.wi, .distance = drawn.distance};
    EXPECT_NEAR(table.pdf({}, drawn.light, hit) / drawn.pdf, 1, 1e-5F);
    EXPECT_FLOAT_EQ(table.pdf({}, drawn.light, hit),
                    table.pmf({}, drawn.light) * pdf(table[drawn.light], {}, hit));
    EXPECT_EQ(drawn.radiance, table[drawn.light].radiance);
    if (drawn.light == 0) {
      EXPECT_EQ(drawn.instance, 7U);
      EXPECT_EQ(drawn.primitive, 9U);
    }
  }
}

}  // namespace
}  // namespace tessera::render
