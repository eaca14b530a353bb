#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/support.hpp"

/// What cameras see, through the whole renderer.
namespace tessera::render::proof {
namespace {

TEST(Orthographic, the_film_s_height_shows_what_is_asked_wherever_the_eye_is) {
  // A lamp of 1 by 1 fills a quarter of a film that shows 2 by 2.
  SceneMaker maker;
  maker.add(maker.emitter(4, true), scene::Quad{{-0.5, -0.5, 0}, {1, 0, 0}, {0, 1, 0}});
  maker.environment(0);
  maker.look({0, 0, 3}, {0, 0, 0}, 40, {0, 1, 0});
  for (const double distance : {0.5, 3.0, 100.0}) {
    maker.description.cameras[0].eye = {0, 0, distance};
    maker.description.cameras[0].projection = scene::Projection::orthographic;
    maker.description.cameras[0].orthographic_height = 2;
    Take take{64, 4};
    take.integrator = "path";
    expect_mean(measure(maker.build(), take), 1.0, 0.02);
  }
}

/// A pixel's mean where a bright half-plane's edge lies `edge` to the right of the line of sight,
/// behind or before the plane of focus, at distance 1.
Estimate seen_at_edge(double distance, double edge, scene::Lens lens) {
  SceneMaker maker;
  maker.add(maker.emitter(1, true), scene::Quad{{edge, -50, -distance}, {100, 0, 0}, {0, 100, 0}});
  maker.environment(0);
  maker.look({0, 0, 0}, {0, 0, -1}, 1e-5, {0, 1, 0});
  lens.focus_distance = 1;
  maker.description.cameras[0].lens = lens;
  return measure(maker.build(), {2, 256});
}

TEST(ThinLens, edge_out_of_focus_is_the_part_of_the_aperture_that_sees_it) {
  // A ray through the aperture's x reaches x·(1 − distance).
  for (const double distance : {0.5, 3.0}) {
    for (const double part : {-0.6, 0.3, 0.8}) {
      const double radius = 0.1, reach = std::abs(1 - distance) * radius;
      const double disk = 0.5 - (part * std::sqrt(1 - part * part) + std::asin(part)) / pi_d;
      expect_mean(seen_at_edge(distance, part * reach, {.radius = radius}), disk, 0.01);
      // Four blades turned by 45° are a square with sides of √2 radii.
      if (std::abs(part) * std::sqrt(2.0) < 1)
        expect_mean(seen_at_edge(distance, part * reach,
                                 {.radius = radius, .blades = 4, .rotation_degrees = 45}),
                    0.5 - part / std::sqrt(2.0), 0.01);
    }
  }
}

TEST(ThinLens, what_is_in_focus_is_sharp) {
  for (const double edge : {-1e-3, 1e-3})
    EXPECT_EQ(seen_at_edge(1, edge, {.radius = 0.5}).mean, edge < 0 ? 1 : 0);
}

TEST(Equirectangular, film_shows_every_direction_once) {
  // A lamp overhead that is seen from 1 below: by latitude φ, rows above the angle of its rim.
  SceneMaker maker;
  maker.add(maker.emitter(1, true), scene::Sphere{{0, 2, 0}, 1});
  maker.environment(0);
  maker.look({0, 0, 0}, {1, 0, 0}, 40, {0, 1, 0});
  maker.description.cameras[0].projection = scene::Projection::equirectangular;
  // Its rim stands asin(1/2) = 30° from straight up: a sixth of all latitudes.
  expect_mean(measure(maker.build(), {30, 16}), 1.0 / 6, 0.01);
}

}  // namespace
}  // namespace tessera::render::proof
