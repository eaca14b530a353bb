#include <gtest/gtest.h>

#include <cmath>

#include "worker/render/lights/light_table.hpp"

/// Lights without a size: the irradiance of a surface at the origin that faces +y.
namespace tessera::render {
namespace {

double received(const Light& light, const Vec3& p = {}) {
  const LightSample drawn = sample(light, {.p = p, .n = {0, 1, 0}}, {0.3F, 0.7F});
  if (!drawn) return 0;
  EXPECT_TRUE(drawn.delta);
  EXPECT_EQ(drawn.pdf, 1);
  return static_cast<double>(drawn.radiance.r * drawn.wi.y);
}

Light light_of(auto shape) { return {.shape = shape, .radiance = gray(6)}; }

TEST(DeltaLight, a_point_gives_intensity_over_distance_squared) {
  EXPECT_NEAR(received(light_of(PointLight{{0, 2, 0}})), 6.0 / 4, 1e-6);
  // From the side: cos θ / d² = (2 / √8) / 8.
  EXPECT_NEAR(received(light_of(PointLight{{2, 2, 0}})), 6 * 2 / std::sqrt(8.0) / 8, 1e-6);
  EXPECT_EQ(received(light_of(PointLight{{0, 2, 0}}), {0, 2, 0}), 0) << "at the point itself";
}

TEST(DeltaLight, a_spot_falls_off_between_its_cones) {
  const float cos_inner = std::cos(0.2F), cos_outer = std::cos(0.5F);
  const auto at = [&](double degrees) {
    const auto radians = static_cast<float>(degrees);
    return received(light_of(SpotLight{.position = {0, 1, 0},
                                       .axis = {std::sin(radians), -std::cos(radians), 0},
                                       .cos_inner = cos_inner,
                                       .cos_outer = cos_outer}));
  };
  EXPECT_NEAR(at(0), 6, 1e-5);
  EXPECT_NEAR(at(0.19), 6, 1e-5);
  const double part = (std::cos(0.35) - std::cos(0.5)) / (std::cos(0.2) - std::cos(0.5));
  EXPECT_NEAR(at(0.35), 6 * part * part, 1e-4);
  EXPECT_EQ(at(0.51), 0);
  EXPECT_EQ(at(3), 0);
}

TEST(DeltaLight, a_directional_one_gives_its_irradiance_everywhere) {
  const Light light = light_of(DirectionalLight{.direction = {0.6F, -0.8F, 0}, .radius = 3});
  EXPECT_NEAR(received(light), 6 * 0.8, 1e-6);
  EXPECT_NEAR(received(light, {100, 50, 7}), 6 * 0.8, 1e-6);
  EXPECT_TRUE(std::isinf(sample(light, {.p = {}}, {0, 0}).distance));
}

TEST(DeltaLight, no_other_way_finds_one) {
  const LightHit hit{.wi = {0, 1, 0}, .distance = 2};
  for (const Light& light :
       {light_of(PointLight{{0, 2, 0}}), light_of(SpotLight{{0, 2, 0}, {0, -1, 0}}),
        light_of(DirectionalLight{})}) {
    EXPECT_EQ(pdf(light, {}, hit), 0);
    EXPECT_TRUE(is_black(emitted(light, {}, hit.wi)));
  }
}

TEST(DeltaLight, power_is_what_goes_out) {
  const auto watts = [](const Light& light) { return static_cast<double>(power(light).r); };
  EXPECT_NEAR(watts(light_of(PointLight{})), 6 * 4 * pi_d, 1e-4);
  EXPECT_NEAR(watts(light_of(DirectionalLight{.radius = 2})), 6 * pi_d * 4, 1e-4);
  // A spot's by summing its falloff over directions.
  const SpotLight spot{.position = {}, .axis = {0, 0, -1}, .cos_inner = 0.9F, .cos_outer = 0.6F};
  double sum = 0;
  constexpr int steps = 20000;
  for (int i = 0; i < steps; ++i) {
    const double cosine = -1 + 2 * (i + 0.5) / steps, sine = std::sqrt(1 - cosine * cosine);
    const Vec3 p = to_float(Vec3d{sine, 0, -cosine});
    const LightSample drawn = sample(light_of(spot), {.p = p}, {});
    if (drawn) sum += static_cast<double>(drawn.radiance.r) * 2 * pi_d * 2 / steps;
  }
  EXPECT_NEAR(watts(light_of(spot)), sum, 1e-3 * sum);
}

TEST(DeltaLight, is_chosen_by_its_intensity) {
  const LightTable table({light_of(PointLight{}), {.shape = PointLight{}, .radiance = gray(18)}});
  const LightContext context{.p = {1, 2, 3}};
  EXPECT_NEAR(table.pmf(context, 0), 0.25, 1e-6);
  EXPECT_NEAR(table.pmf(context, 1), 0.75, 1e-6);
}

}  // namespace
}  // namespace tessera::render
