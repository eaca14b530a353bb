#pragma once
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <string>
#include <utility>

#include "tests/render/support.hpp"

/// A ball above a ground that catches its shadow, and what tasks take of it.
namespace tessera::render::proof::catchers {

inline constexpr scene::Visibility catching{.shadow_catcher = true};
inline constexpr int side = 32;

inline scene::Quad ground() { return {{-20, 0, 20}, {40, 0, 0}, {0, 0, -40}}; }

/// A catching ground that is not white, and a ball above it.
inline SceneMaker ball_over_ground(const scene::Visibility& of_ground = catching) {
  SceneMaker maker;
  maker.add(maker.diffuse(0.5), ground());
  maker.description.shapes.back().visibility = of_ground;
  maker.add(maker.diffuse(0.25), scene::Sphere{{0, 1, 0}, 0.7});
  maker.look({0, 5, 7}, {0, 0.5, 0}, 40, {0, 1, 0});
  maker.description.film_transparent = true;
  return maker;
}

/// A sky, a lamp and a point of light.
inline void add_lights_of_all_kinds(SceneMaker& maker) {
  maker.environment(0.5);
  maker.add(maker.emitter(8), scene::Quad{{-1, 6, -1}, {2, 0, 0}, {0, 0, 2}});
  // Else it stands before the sky.
  maker.description.shapes.back().visibility.shadow = false;
  maker.description.lights.push_back({"p", scene::PointLight{{2, 4, 1}, {50, 50, 50}}});
}

inline TaskRequest request_for(int samples, const std::string& integrator = "path") {
  TaskRequest request = request_of({.side = side, .samples = samples, .integrator = integrator}, 5);
  request.settings.aovs = {"albedo", "N", "Z", "P", "object_id", "shadow_catcher"};
  return request;
}

inline image::TileImage taken(const Scene& scene, const TaskRequest& request, int threads = 2) {
  tbb::task_arena arena(threads);
  auto done = render_task(scene, request, arena);
  EXPECT_TRUE(done.has_value());
  EXPECT_EQ(done->stats.rejected, 0);
  return std::move(done->image);
}

inline image::TileImage taken(const SceneMaker& maker, int samples = 16) {
  return taken(maker.build(), request_for(samples));
}

inline std::size_t first_of(const image::TileImage& image) {
  return static_cast<std::size_t>(image.layout->index_of("shadow_catcher.R"));
}
inline float caught(const image::TileImage& image, CaughtChannel channel, std::size_t pixel) {
  return image.plane(first_of(image) + channel)[pixel];
}

/// What the picture's alpha is to be.
inline double alpha(const image::TileImage& image, std::size_t pixel) {
  const double open = caught(image, unshadowed_G, pixel);
  const double lit = open > 0 ? caught(image, caught_G, pixel) / open : 1;
  return image.plane(image::A)[pixel] + caught(image, caught_coverage, pixel) * (1 - lit);
}

}  // namespace tessera::render::proof::catchers
