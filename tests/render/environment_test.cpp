#include <gtest/gtest.h>

#include "tests/render/support.hpp"

/// An environment that is a picture, from its bytes to the light that it gives.
namespace tessera::render::proof {
namespace {

/// The middle of a plane of albedo ½, seen from above, under the picture.
Scene plane_under(const std::vector<int>& exponents, double strength) {
  SceneMaker maker;
  maker.add(maker.diffuse(0.5), scene::Quad{{-5, 0, 5}, {10, 0, 0}, {0, 0, -10}});
  maker.look({0, 3, 0}, {0, 0, 0}, 5, {0, 0, -1});
  maker.description.images = {picture_of(1, exponents)};
  maker.description.environment =
      scene::Environment{.radiance = {1, 1, 1}, .image = 0, .strength = strength};
  return maker.build();
}

TEST(EnvironmentPicture, one_that_is_the_same_everywhere_lights_as_a_constant_does) {
  const Scene scene = plane_under({0, 0, 0, 0}, 3);
  expect_mean(measure(scene, {.side = 2, .samples = 1024}), 1.5);
}

TEST(EnvironmentPicture, light_samples_and_found_light_give_what_chance_alone_gives) {
  const Scene scene = plane_under({3, -1, 0, -128, -128, 2}, 1);
  const Estimate by_chance = measure(scene, {.side = 4, .samples = 4096, .integrator = "cosine"});
  const Estimate by_path = measure(scene, {.side = 4, .samples = 1024});
  expect_mean(by_path, by_chance.mean);
  EXPECT_GT(by_path.mean, 0.1);
}

TEST(EnvironmentPicture, the_camera_sees_it_and_strength_multiplies_it) {
  SceneMaker maker;
  maker.look({0, 0, 0}, {0, 1, 0}, 5, {1, 0, 0});
  maker.description.images = {picture_of(1, {2, 0})};
  maker.description.environment =
      scene::Environment{.radiance = {1, 1, 1}, .image = 0, .strength = 0.5};
  const RenderedTask seen = render(maker.build(), {.side = 4, .samples = 4}, 1);
  for (const float value : seen.image.plane(image::R)) EXPECT_NEAR(value, 2, 1e-5);
}

}  // namespace
}  // namespace tessera::render::proof
