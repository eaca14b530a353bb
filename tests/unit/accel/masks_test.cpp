#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "worker/accel/accel.hpp"
#include "worker/accel/buffer.hpp"

namespace tessera::accel {
namespace {

constexpr Mask first = 1, second = 2;

/// Down the z axis at `x`.
Ray down_at(float x) {
  Ray ray;
  ray.origin = {x, 0, 9};
  ray.direction = {0, 0, -1};
  ray.far = std::numeric_limits<float>::infinity();
  return ray;
}

/// One of each kind, at x = 0, 10, 20, 30, all of one mask.
struct OfEachKind {
  Device device;
  Buffer<Point> points{12};
  Buffer<Triangle> triangles{1};
  Buffer<Quad> quads{1}, around{1};
  Buffer<Sphere> spheres{1};
  Scene scene{device};
  static constexpr std::array<float, 4> places{0, 10, 20, 30};

  explicit OfEachKind(Mask mask) {
    for (std::uint32_t kind = 0; kind < 3; ++kind) {
      const float x = places[kind];
      points[4 * kind] = {x - 1, -1, 0};
      points[4 * kind + 1] = {x + 1, -1, 0};
      points[4 * kind + 2] = {x + 1, 1, 0};
      points[4 * kind + 3] = {x - 1, 1, 0};
    }
    // The triangle's lower edge is the quad's, its third corner beyond the middle.
    points[2] = {0, 3, 0};
    triangles[0] = {0, 1, 2};
    quads[0] = {4, 5, 6, 7};
    around[0] = {8, 9, 10, 11};
    spheres[0] = {{places[3], 0, 0}, 1};
    const std::array<std::span<const Point>, 1> keys{points.span()};
    scene.add_triangles(keys, triangles.span(), mask);
    scene.add_quads(keys, quads.span(), mask);
    scene.add_ellipses(keys, around.span(), mask);
    scene.add_spheres(spheres.span(), mask);
    scene.build();
  }
};

TEST(Masks, ARayMeetsWhatItSharesABitWith) {
  const OfEachKind all(second);
  for (const float x : OfEachKind::places) {
    const Ray ray = down_at(x);
    EXPECT_FALSE(all.scene.intersect(ray, first).any()) << x;
    EXPECT_FALSE(all.scene.occluded(ray, first)) << x;
    EXPECT_TRUE(all.scene.intersect(ray, second).any()) << x;
    EXPECT_TRUE(all.scene.occluded(ray, first | second)) << x;
    EXPECT_TRUE(all.scene.intersect(ray).any()) << x;
  }
}

TEST(Masks, WhatHasNoneOfItsOwnIsMetByAll) {
  const OfEachKind all(everything);
  for (const float x : OfEachKind::places) {
    EXPECT_TRUE(all.scene.intersect(down_at(x), first).any()) << x;
    EXPECT_TRUE(all.scene.occluded(down_at(x), Mask{1} << 31U)) << x;
  }
}

TEST(Masks, ARayMeetsWhatIsInAnInstanceIfItMeetsBoth) {
  const OfEachKind all(everything), hidden(everything & ~first);
  const std::array<Affine, 1> here{Affine{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
  const auto met = [&](const OfEachKind& child, Mask of_instance, Mask of_ray) {
    Scene world(child.device);
    world.add_instance(child.scene, here, of_instance);
    world.build();
    int count = 0;
    for (const float x : OfEachKind::places) {
      EXPECT_EQ(world.intersect(down_at(x), of_ray).any(), world.occluded(down_at(x), of_ray));
      if (world.occluded(down_at(x), of_ray)) ++count;
    }
    return count;
  };
  EXPECT_EQ(met(all, everything, first), 4);
  EXPECT_EQ(met(all, second, first), 0);
  EXPECT_EQ(met(all, second, second), 4);
  EXPECT_EQ(met(hidden, everything, first), 0);
  EXPECT_EQ(met(hidden, everything, second), 4);
}

}  // namespace
}  // namespace tessera::accel
