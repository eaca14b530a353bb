#include "worker/accel/accel.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "common/base/error.hpp"
#include "worker/accel/buffer.hpp"

namespace tessera::accel {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

Ray ray_from(Point origin, Point direction, float far = infinity) {
  Ray ray;
  ray.origin = origin;
  ray.direction = direction;
  ray.far = far;
  return ray;
}

/// A unit square at z = 0 as a quad, and a triangle at z = 1 over its lower left half.
struct Small {
  Device device;
  Buffer<Point> square{4}, corner{3};
  Buffer<Quad> quads{1};
  Buffer<Triangle> triangles{1};
  Buffer<Sphere> spheres{1};
  Scene scene{device};

  Small() {
    square[0] = {0, 0, 0};
    square[1] = {2, 0, 0};
    square[2] = {2, 1, 0};
    square[3] = {0, 1, 0};
    quads[0] = {0, 1, 2, 3};
    corner[0] = {0, 0, 1};
    corner[1] = {1, 0, 1};
    corner[2] = {0, 1, 1};
    triangles[0] = {0, 1, 2};
    spheres[0] = {{5, 0, 0}, 1};
    const std::array<std::span<const Point>, 1> square_keys{square.span()};
    const std::array<std::span<const Point>, 1> corner_keys{corner.span()};
    EXPECT_EQ(scene.add_quads(square_keys, quads.span()), 0U);
    EXPECT_EQ(scene.add_triangles(corner_keys, triangles.span()), 1U);
    EXPECT_EQ(scene.add_spheres(spheres.span()), 2U);
  }
};

TEST(Accel, AHitNamesGeometryPrimitiveAndPlaceOnAQuad) {
  Small small;
  small.scene.build();
  const Hit hit = small.scene.intersect(ray_from({1.5F, 0.75F, 3}, {0, 0, -1}));
  ASSERT_TRUE(hit.any());
  EXPECT_EQ(hit.geometry, 0U);
  EXPECT_EQ(hit.primitive, 0U);
  EXPECT_EQ(hit.instance, none);
  EXPECT_FLOAT_EQ(hit.u, 0.75F);
  EXPECT_FLOAT_EQ(hit.v, 0.75F);
  EXPECT_FLOAT_EQ(hit.t, 3);
  EXPECT_GT(hit.ng[2], 0);
}

TEST(Accel, ATriangleInFrontHidesTheQuad) {
  Small small;
  small.scene.build();
  const Hit hit = small.scene.intersect(ray_from({0.25F, 0.5F, 3}, {0, 0, -1}));
  ASSERT_TRUE(hit.any());
  EXPECT_EQ(hit.geometry, 1U);
  EXPECT_FLOAT_EQ(hit.u, 0.25F);
  EXPECT_FLOAT_EQ(hit.v, 0.5F);
  EXPECT_FLOAT_EQ(hit.t, 2);
  EXPECT_GT(hit.ng[2], 0);
}

TEST(Accel, NothingIsHitBeyondTheRaysEnd) {
  Small small;
  small.scene.build();
  EXPECT_FALSE(small.scene.intersect(ray_from({1.5F, 0.75F, 3}, {0, 0, -1}, 2.9F)).any());
  EXPECT_FALSE(small.scene.occluded(ray_from({1.5F, 0.75F, 3}, {0, 0, -1}, 2.9F)));
  EXPECT_TRUE(small.scene.occluded(ray_from({1.5F, 0.75F, 3}, {0, 0, -1}, 3.1F)));
  EXPECT_FALSE(small.scene.occluded(ray_from({1.5F, 0.75F, 3}, {0, 0, 1})));
}

TEST(Accel, ASphereIsMetFromOutsideAndFromInside) {
  Small small;
  small.scene.build();
  const Hit outside = small.scene.intersect(ray_from({5, 0, 10}, {0, 0, -2}));
  ASSERT_TRUE(outside.any());
  EXPECT_EQ(outside.geometry, 2U);
  EXPECT_FLOAT_EQ(outside.t, 4.5F);
  EXPECT_FLOAT_EQ(outside.ng[2], 1);
  const Hit inside = small.scene.intersect(ray_from({5, 0, 0}, {0, 0, -2}));
  ASSERT_TRUE(inside.any());
  EXPECT_FLOAT_EQ(inside.t, 0.5F);
  EXPECT_FLOAT_EQ(inside.ng[2], -1);
  EXPECT_TRUE(small.scene.occluded(ray_from({5, 0, 0}, {0, 1, 0}, 1.1F)));
  EXPECT_FALSE(small.scene.occluded(ray_from({5, 0, 0}, {0, 1, 0}, 0.9F)));
}

TEST(Accel, AFarAndHugeSphereIsMetToAFloatsPrecision) {
  const Device device;
  Buffer<Sphere> spheres(1);
  spheres[0] = {{0, -1e6F, 0}, 1e6F};
  Scene scene(device);
  scene.add_spheres(spheres.span());
  scene.build();
  for (int i = 0; i < 100; ++i) {
    const float x = static_cast<float>(i) * 0.37F;
    const double expected =
        1000.0 - (std::sqrt(1e12 - static_cast<double>(x) * static_cast<double>(x)) - 1e6);
    const Hit hit = scene.intersect(ray_from({x, 1000, 0}, {0, -1, 0}));
    ASSERT_TRUE(hit.any());
    EXPECT_NEAR(hit.t, expected, expected * 1e-7) << x;
  }
}

TEST(Accel, AnInstanceIsMovedAndNamed) {
  Small small;
  small.scene.build();
  Scene world(small.device);
  const std::array<Affine, 1> there{Affine{2, 0, 0, 100, 0, 2, 0, 0, 0, 0, 2, 0}};
  const std::array<Affine, 1> here{Affine{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
  EXPECT_EQ(world.add_instance(small.scene, here), 0U);
  EXPECT_EQ(world.add_instance(small.scene, there), 1U);
  world.build();
  const Hit hit = world.intersect(ray_from({103, 1, 9}, {0, 0, -1}));
  ASSERT_TRUE(hit.any());
  EXPECT_EQ(hit.instance, 1U);
  EXPECT_EQ(hit.geometry, 0U);
  EXPECT_FLOAT_EQ(hit.t, 9);
  EXPECT_FLOAT_EQ(hit.u, 0.75F);
  const Hit ball = world.intersect(ray_from({110, 0, 9}, {0, 0, -1}));
  ASSERT_TRUE(ball.any());
  EXPECT_EQ(ball.instance, 1U);
  EXPECT_EQ(ball.geometry, 2U);
  EXPECT_FLOAT_EQ(ball.t, 7);
}

TEST(Accel, SpansGiveWhatSingleRaysGive) {
  Small small;
  small.scene.build();
  std::vector<Ray> rays;
  for (int i = 0; i < 60; ++i) {
    rays.push_back(ray_from({static_cast<float>(i) * 0.1F, 0.4F, 4}, {0, 0.01F, -1}));
  }
  std::vector<Hit> hits(rays.size());
  std::vector<std::uint8_t> hidden(rays.size());
  small.scene.intersect(rays, hits);
  small.scene.occluded(rays, hidden);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Hit single = small.scene.intersect(rays[i]);
    EXPECT_EQ(single.geometry, hits[i].geometry);
    EXPECT_EQ(single.t, hits[i].t);
    EXPECT_EQ(single.any(), hidden[i] != 0);
  }
}

TEST(Accel, MovingPositionsAreMetWhereTheyAreAtTheRaysTime) {
  const Device device;
  Buffer<Point> first(3), second(3);
  Buffer<Triangle> triangles(1);
  triangles[0] = {0, 1, 2};
  for (std::size_t i = 0; i < 3; ++i) {
    const float x = i == 1 ? 1.0F : 0.0F, y = i == 2 ? 1.0F : 0.0F;
    first[i] = {x, y, 0};
    second[i] = {x + 10, y, 0};
  }
  Scene scene(device);
  const std::array<std::span<const Point>, 2> keys{first.span(), second.span()};
  scene.add_triangles(keys, triangles.span());
  scene.build();
  Ray ray = ray_from({5.2F, 0.2F, 1}, {0, 0, -1});
  ray.time = 0.5F;
  EXPECT_TRUE(scene.intersect(ray).any());
  ray.time = 0;
  EXPECT_FALSE(scene.intersect(ray).any());
}

TEST(Accel, TheVersionNamesTheInstructionSetAskedFor) {
  EXPECT_EQ(Device({"avx2"}).version().rfind("embree ", 0), 0U);
  EXPECT_NE(Device({"sse2"}).version().find("isa=sse2"), std::string::npos);
}

TEST(Accel, MemoryIsCounted) {
  Small small;
  const std::int64_t before = small.device.memory();
  small.scene.build();
  EXPECT_GT(small.device.memory(), before);
  EXPECT_GE(small.device.memory_peak(), small.device.memory());
}

TEST(LargeVector, HoldsWhatIsPutInOnEitherSideOfAHugePage) {
  for (const std::size_t count : {1000U, (1U << 19) - 1, (1U << 19) + 1, 1'000'003U}) {
    LargeVector<std::uint32_t> values(count);
    for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<std::uint32_t>(i * 3);
    const LargeVector<std::uint32_t> copy = values;
    EXPECT_EQ(copy, values);
    EXPECT_EQ(copy.back(), 3 * (count - 1));
  }
}

TEST(Accel, ABuildCanBeGivenUp) {
  const Device device;
  constexpr std::size_t count = 200000;
  Buffer<Point> points(count * 3);
  Buffer<Triangle> triangles(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const float x = static_cast<float>(i % 500), y = static_cast<float>(i / 500);
    points[3 * i] = {x, y, 0};
    points[3 * i + 1] = {x + 1, y, 0};
    points[3 * i + 2] = {x, y + 1, 0};
    triangles[i] = {3 * i, 3 * i + 1, 3 * i + 2};
  }
  Scene scene(device);
  const std::array<std::span<const Point>, 1> keys{points.span()};
  scene.add_triangles(keys, triangles.span());
  EXPECT_THROW(scene.build([](double) { return false; }), Error);
}

}  // namespace
}  // namespace tessera::accel
