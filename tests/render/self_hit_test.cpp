#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/render/support.hpp"
#include "worker/render/interaction.hpp"
#include "worker/render/warp.hpp"

/// A ray that leaves what is flat, or what is round from outside, never meets it again.
namespace tessera::render::proof {
namespace {

constexpr float endless = std::numeric_limits<float>::infinity();

class Numbers {
 public:
  float next() { return static_cast<float>(generator_() >> 8U) * 0x1p-24F; }
  /// Uniform over all directions.
  Vec3 direction() {
    const float z = 2 * next() - 1, turn = 2 * pi * next();
    const float sine = std::sqrt(std::max(0.0F, 1 - z * z));
    return {sine * std::cos(turn), sine * std::sin(turn), z};
  }

 private:
  std::mt19937 generator_{7};
};

/// Flat things of every kind, spheres and ellipsoids, and an object that is placed twice.
SceneMaker things(const scene::Transform& turn) {
  SceneMaker maker;
  const std::uint32_t white = maker.diffuse(1);
  maker.add(white, scene::Quad{{-2, -1.3, -2}, {4, 0, 0}, {0, 0.3, 4}}, turn);
  maker.add(white, scene::Disk{{0.9, 0.2, 0.4}, {1, 2, -1}, 0.7}, turn);
  maker.add(white, scene::Box{{-1.7, -1, -0.4}, {-0.9, 0.3, 0.6}}, turn);
  maker.add(white, scene::Sphere{{0.3, -0.4, -0.9}, 0.6}, turn);
  maker.add(white, scene::Sphere{{-0.4, 1, 0.2}, 0.5}, turn * scale(1, 0.4, 1.3));
  maker.add(white, ball(2, false), turn * translate(0.2, 0.9, 0.9) * scale(0.4, 0.3, 0.4));
  scene::Shape part;
  part.geometry = ball(1, false);
  part.material = white;
  maker.description.objects = {{"twice", {part}}};
  maker.description.instances = {{0, turn * translate(1.4, -0.3, -0.6) * scale(0.3, 0.8, 0.3)},
                                 {0, turn * translate(-0.3, -0.8, 1.2) * scale(0.4, 0.1, 0.2)}};
  return maker;
}

struct Count {
  int left = 0;  ///< rays that left a surface
  int again = 0;
};

/// Sends rays at what stands within `reach` of `place` and, from all that they meet, rays to either
/// side: one in two almost within the surface.
Count self_hits(const Scene& scene, const Vec3d& place, float reach) {
  Numbers numbers;
  Count count;
  const Vec3 middle = to_float(place - Vec3d{scene.origin[0], scene.origin[1], scene.origin[2]});
  for (int i = 0; i < 20'000; ++i) {
    Ray ray;
    ray.origin = middle + numbers.direction() * (1.5F * reach);
    ray.direction = normalize(middle + numbers.direction() * (0.6F * reach) - ray.origin);
    ray.t_max = endless;
    const accel::Hit hit = scene.intersect(ray);
    if (!hit.any()) continue;
    const Interaction at = surface_at(scene, ray, hit);
    const bool round = scene.geometry_of(hit).kind == GeometryKind::spheres;
    for (int k = 0; k < 8; ++k) {
      Vec3 out = numbers.direction();
      const float height = dot(out, at.shading.normal);
      if (k % 2 == 0) out = normalize(out - at.shading.normal * (height * (1 - 1e-4F)));
      if (round && dot(out, at.shading.normal) < 0) continue;  // through it, to its far side
      const accel::Hit next = scene.intersect(at.leave(out, endless, ray));
      ++count.left;
      const bool same = next.any() && next.geometry == hit.geometry &&
                        next.primitive == hit.primitive && next.instance == hit.instance;
      count.again += same ? 1 : 0;
    }
  }
  return count;
}

void expect_none(const SceneMaker& maker, const std::string& what, const Vec3d& place = {},
                 double size = 1) {
  const Count count = self_hits(maker.build(), place, static_cast<float>(3 * size));
  EXPECT_GT(count.left, 50'000) << what;
  EXPECT_EQ(count.again, 0) << "of " << count.left << ", " << what;
}

TEST(SelfHit, ThereIsNoneAtAnySize) {
  for (const double factor : {1e-3, 0x1p-10, 1.0, 0x1p10, 1e3}) {
    SceneMaker maker = things({});
    maker.scaled(factor, {0, 0, 0});
    expect_none(maker, "scaled by " + std::to_string(factor), {}, factor);
  }
}

TEST(SelfHit, ThereIsNoneHoweverItIsTurnedAndMoved) {
  for (const double degrees : {17.0, 45.0, 131.0})
    expect_none(things(rotate({1, 2, 0.5}, degrees)), "turned");
  for (const double away : {10.0, 1e3}) {
    const Vec3d place{away, -2 * away, 0.3 * away};
    SceneMaker maker = things(translate(place.x, place.y, place.z) * rotate({3, 1, 1}, 64));
    // Something far off, so that no origin takes the place back.
    maker.add(maker.diffuse(0.5), scene::Sphere{{-place.x, -place.y, -place.z}, 1e-3});
    expect_none(maker, "moved by " + std::to_string(away), place);
  }
}

}  // namespace
}  // namespace tessera::render::proof
