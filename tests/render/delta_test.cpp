#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/support.hpp"

/// Lights without a size, through the whole renderer.
namespace tessera::render::proof {
namespace {

constexpr double albedo = floor_albedo;

template <class Shape>
void shine(SceneMaker& maker, Shape shape) {
  maker.description.lights.push_back({.name = "light", .shape = shape});
}

TEST(Delta, a_point_in_the_centre_of_a_sphere) {
  SceneMaker maker;
  maker.add(maker.diffuse(albedo), scene::Sphere{{0, 0, 0}, 1});
  maker.look({0.1, 0.2, 0}, {0.4, 0.9, 0.1});
  shine(maker, scene::PointLight{.position = {0, 0, 0}, .intensity = {pi_d, pi_d, pi_d}});
  // No noise here. Light is asked for a hit's rounding error off the surface, that much nearer to
  // the lamp: its square is what is left.
  EXPECT_NEAR(measure(maker.build(), {4, 16}).mean, 0.5, 1e-5);
  expect_mean(measure(maker.build(), {4, 256, 64}), 1.0);
}

TEST(Delta, each_lights_a_floor_as_its_formula_says) {
  SceneMaker point = floor_scene();
  shine(point, scene::PointLight{.position = {1, 2, 0}, .intensity = {3, 3, 3}});
  expect_mean(measure(point.build(), {4, 16}), reflected(3 * 2 / std::pow(5.0, 1.5)));

  SceneMaker sun = floor_scene();
  shine(sun, scene::DirectionalLight{.direction = {3, -4, 0}, .irradiance = {2, 2, 2}});
  expect_mean(measure(sun.build(), {4, 16}), reflected(2 * 0.8));

  SceneMaker spot = floor_scene();
  shine(spot, scene::SpotLight{.position = {0, 2, 0},
                               .direction = {std::tan(0.3), -1, 0},
                               .intensity = {8, 8, 8},
                               .inner_degrees = 0,
                               .outer_degrees = 60});
  const double part = (std::cos(0.3) - 0.5) / 0.5;
  expect_mean(measure(spot.build(), {4, 16}), reflected(8.0 / 4 * part * part));
}

TEST(Delta, a_sun_with_an_angle_gives_its_irradiance_by_light_samples_and_by_chance) {
  for (const double angle : {0.53, 40.0, 70.0}) {
    SceneMaker sun = floor_scene();
    shine(sun, scene::DirectionalLight{
                   .direction = {3, -4, 0}, .irradiance = {2, 2, 2}, .angle_degrees = angle});
    const Scene scene = sun.build();
    // All of it above the horizon: as much as from its middle.
    for (const char* integrator : {"path", "hemisphere_lights", "cosine", "hemisphere"}) {
      if (angle < 1 && std::string(integrator) != "path") continue;
      Take take{4, 256};
      take.integrator = integrator;
      expect_mean(measure(scene, take), reflected(2 * 0.8), 0.02);
    }
  }
}

TEST(Delta, a_sun_with_an_angle_stands_in_the_sky) {
  SceneMaker maker;
  shine(maker, scene::DirectionalLight{
                   .direction = {0, 0, 1}, .irradiance = {2, 2, 2}, .angle_degrees = 60});
  maker.look({0, 0, 5}, {0, 0, 0}, 10);
  // π·sin²(30°)·L = E.
  const RenderedTask seen = render(maker.build(), {.side = 4, .samples = 4}, 1);
  for (const float value : seen.image.plane(image::R)) EXPECT_NEAR(value, 8 / pi_d, 1e-5);
}

TEST(Delta, what_stands_between_hides_them) {
  SceneMaker maker = floor_scene();
  maker.add(maker.diffuse(0), scene::Quad{{-5, 1, -5}, {0, 0, 10}, {10, 0, 0}});
  shine(maker, scene::DirectionalLight{.direction = {0, -1, 0}});
  shine(maker, scene::PointLight{.position = {0, 2, 0}});
  EXPECT_EQ(measure(maker.build(), {4, 16}, 4).mean, 0);
}

TEST(Delta, they_share_a_picture_with_lights_that_have_a_size) {
  SceneMaker maker = floor_scene();
  maker.add(maker.emitter(1), scene::Quad{{-1, 1, -1}, {2, 0, 0}, {0, 0, 2}});
  shine(maker, scene::PointLight{.position = {0, 0.5, 0}, .intensity = {0.25, 0.25, 0.25}});
  for (const char* integrator : {"path", "hemisphere_lights"}) {
    Take take{4, 1024};
    take.integrator = integrator;
    expect_mean(measure(maker.build(), take), reflected(pi_d * 0.5541264 + 1), 0.02);
  }
}

}  // namespace
}  // namespace tessera::render::proof
