#include <gtest/gtest.h>

#include <cmath>

#include "common/image/picture.hpp"
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

/// A picture of floats: L = cosⁿ of the angle from what is up, black below.
scene::Image sky_of(int n) {
  constexpr int height = 512;
  image::FrameImage frame{.width = 1, .height = height, .values = {}, .samples = {}};
  frame.values.resize(image::channel_count * frame.pixels());
  frame.samples.resize(frame.pixels());
  for (std::size_t y = 0; y < height; ++y) {
    const double cosine = std::cos(pi_d * (static_cast<double>(y) + 0.5) / height);
    for (const std::size_t channel : {image::R, image::G, image::B})
      frame.plane(channel)[y] = static_cast<float>(cosine > 0 ? std::pow(cosine, n) : 0.0);
    frame.plane(image::A)[y] = 1;
  }
  return {"sky.exr", std::make_shared<const std::vector<std::byte>>(image::encode_exr(frame, {}))};
}

TEST(EnvironmentPicture, a_sky_of_a_power_of_the_cosine_gives_its_irradiance) {
  for (const int n : {1, 2, 8}) {
    SceneMaker maker;
    maker.add(maker.diffuse(0.5), scene::Quad{{-5, 0, 5}, {10, 0, 0}, {0, 0, -10}});
    maker.look({0, 3, 0}, {0, 0, 0}, 5, {0, 0, -1});
    maker.description.images = {sky_of(n)};
    maker.description.environment = scene::Environment{.radiance = {1, 1, 1}, .image = 0};
    const Scene scene = maker.build();
    const double expected = 0.5 / pi_d * 2 * pi_d / (n + 2);
    for (const char* integrator : {"path", "hemisphere_lights"})
      expect_mean(measure(scene, {4, 256, 0, 1, 2, integrator}), expected, 0.01);
  }
}

TEST(EnvironmentPicture, a_sun_in_a_picture_is_found_by_all_integrators_alike) {
  // Compensated light samples leave the sky to paths; those of other integrators may not.
  const Scene scene = plane_under({0, 0, 7, 0, 0, 0, 0, -2}, 1);
  const Estimate by_chance = measure(scene, {.side = 4, .samples = 2048, .integrator = "cosine"});
  for (const char* integrator : {"path", "hemisphere_lights"}) {
    const Estimate found = measure(scene, {4, 512, 0, 1, 2, integrator});
    const double error = std::sqrt(found.error * found.error + by_chance.error * by_chance.error);
    EXPECT_NEAR(found.mean, by_chance.mean, student_bound(23) * error) << integrator;
    EXPECT_LT(error, 0.01 * found.mean) << integrator;
  }
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
