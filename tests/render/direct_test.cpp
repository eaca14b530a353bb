#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/render/support.hpp"
#include "worker/render/octahedral.hpp"

/// Irradiance of a small element, read as the radiance of a diffuse surface.
namespace tessera::render::proof {
namespace {

constexpr double albedo = floor_albedo;

/// Form factor of a parallel rectangle with a corner above the element.
double parallel(double a, double b, double h) {
  const double x = a / h, y = b / h;
  const double u = std::sqrt(1 + x * x), v = std::sqrt(1 + y * y);
  return (x / u * std::atan(y / u) + y / v * std::atan(x / v)) / (2 * pi_d);
}

/// Of a perpendicular rectangle: height a, width b, distance c, the element in the plane of one of
/// its upright edges.
double perpendicular(double a, double b, double c) {
  const double x = a / b, y = c / b, r = std::sqrt(x * x + y * y);
  return (std::atan(1 / y) - y / r * std::atan(1 / r)) / (2 * pi_d);
}

/// A rectangle at height h that shines down, from (x, z) with sides a along x and b along z.
scene::Quad lamp(double x, double z, double a, double b, double h) {
  return {{x, h, z}, {a, 0, 0}, {0, 0, b}};
}

TEST(Direct, FormulasAgreeWithTheFacts) {
  EXPECT_NEAR(parallel(1, 1, 1), 0.1385316, 1e-7);
  EXPECT_NEAR(4 * parallel(1, 1, 1), 0.5541264, 1e-7);
  EXPECT_NEAR(perpendicular(1, 1, 1), 0.0557342, 1e-7);
  EXPECT_NEAR(perpendicular(2, 1, 0.5), 0.1587748, 1e-7);
}

TEST(Direct, RectangleWithACornerAboveTheElement) {
  SceneMaker maker = floor_scene();
  maker.add(maker.emitter(1), lamp(0, 0, 1, 1, 1));
  expect_mean(measure(maker.build(), {}), reflected(pi_d * 0.1385316));
}

TEST(Direct, CentredRectangles) {
  const struct {
    double side, h, factor;
  } cases[] = {{2, 1, 0.5541264}, {1, 1, 0.2394565}, {1, 2, 0.0734776}};
  for (const auto& one : cases) {
    SceneMaker maker = floor_scene();
    maker.add(maker.emitter(1), lamp(-one.side / 2, -one.side / 2, one.side, one.side, one.h));
    expect_mean(measure(maker.build(), {}), reflected(pi_d * one.factor));
  }
}

TEST(Direct, ARectangleOfTrianglesGivesTheSame) {
  const std::vector<std::array<std::uint32_t, 3>> in_halves = {{0, 1, 2}, {0, 2, 3}};
  // About a point that is off the middle.
  const std::vector<std::array<std::uint32_t, 3>> in_quarters = {
      {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  const struct {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::size_t lights;
  } cases[] = {{in_halves, 1}, {in_quarters, 4}};
  for (const auto& one : cases) {
    SceneMaker maker = floor_scene();
    scene::Mesh mesh;
    mesh.positions = {{-1, 1, -1}, {1, 1, -1}, {1, 1, 1}, {-1, 1, 1}, {0.25F, 1, 0.5F}};
    mesh.triangles = one.triangles;
    maker.add(maker.emitter(1), mesh);
    const Scene scene = maker.build();
    ASSERT_EQ(scene.lights.size(), one.lights);
    expect_mean(measure(scene, {4, 256}), reflected(pi_d * 0.5541264));
  }
}

TEST(Direct, NoMatterHowManyLightSamples) {
  SceneMaker maker = floor_scene();
  maker.add(maker.emitter(1), lamp(-1, -1, 2, 2, 1));
  maker.add(maker.emitter(3), scene::Sphere{{0.5, 0.8, 0}, 0.1});
  const Scene scene = maker.build();
  const Estimate one = measure(scene, {4, 256, 0, 1});
  for (const int count : {2, 5, 16}) {
    const Estimate many = measure(scene, {4, 256, 0, count});
    const double error = std::sqrt(one.error * one.error + many.error * many.error);
    EXPECT_NEAR(many.mean, one.mean, student_bound(23) * error) << count;
    EXPECT_LT(many.error, one.error) << count;
  }
}

TEST(Direct, PerpendicularRectangle) {
  const struct { double a, b, c, factor; } cases[] = {{1, 1, 1, 0.0557342}, {2, 1, 0.5, 0.1587748}};
  for (const auto& one : cases) {
    SceneMaker maker = floor_scene();
    // Upright at x = c, from z = 0 to b, shining towards −x.
    maker.add(maker.emitter(1), scene::Quad{{one.c, 0, 0}, {0, 0, one.b}, {0, one.a, 0}});
    expect_mean(measure(maker.build(), {}), reflected(pi_d * one.factor));
  }
}

TEST(Direct, SphereAboveTheHorizon) {
  for (const double angle : {0.0, 30.0, 60.0}) {
    const double d = 2, radius = 0.5, theta = angle * pi_d / 180;
    SceneMaker maker = floor_scene();
    maker.add(maker.emitter(1),
              scene::Sphere{{d * std::sin(theta), d * std::cos(theta), 0}, radius});
    expect_mean(measure(maker.build(), {}),
                reflected(pi_d * radius * radius / (d * d) * std::cos(theta)));
  }
}

TEST(Direct, ASphereAsLargeAsTheSun) {
  SceneMaker maker = floor_scene();
  const double radius = 1000 * std::sin(0.2665 * pi_d / 180);
  maker.add(maker.emitter(1), scene::Sphere{{0, 1000, 0}, radius});
  expect_mean(measure(maker.build(), {}), reflected(6.796666e-5));
}

TEST(Direct, AnEmittersBackIsDark) {
  SceneMaker maker = floor_scene();
  maker.add(maker.emitter(1), scene::Quad{{-1, 1, -1}, {0, 0, 2}, {2, 0, 0}});
  const Estimate estimate = measure(maker.build(), {});
  EXPECT_EQ(estimate.mean, 0);
}

TEST(Direct, ATwoSidedEmitterShinesBothWays) {
  SceneMaker maker = floor_scene();
  maker.add(maker.emitter(1, true), scene::Quad{{-1, 1, -1}, {0, 0, 2}, {2, 0, 0}});
  expect_mean(measure(maker.build(), {}), reflected(pi_d * 0.5541264));
}

TEST(Direct, ConstantEnvironment) {
  SceneMaker maker = floor_scene();
  maker.environment(2);
  expect_mean(measure(maker.build(), {}), reflected(pi_d * 2));
}

TEST(Direct, ALampAndTheEnvironmentShareTheLightSamples) {
  // The lamp hides what it covers of the sky.
  SceneMaker maker = floor_scene();
  maker.environment(2);
  maker.add(maker.emitter(3), lamp(-0.5, -0.5, 1, 1, 1));
  expect_mean(measure(maker.build(), {}), reflected(pi_d * (2 + (3 - 2) * 0.2394565)));
}

TEST(Direct, AWideGroundDoesNotStarveALamp) {
  // By the sphere around the scene the environment had nearly all of the power.
  SceneMaker maker;
  constexpr double reach = 1e4;
  maker.add(maker.diffuse(albedo),
            scene::Quad{{-reach, 0, -reach}, {0, 0, 2 * reach}, {2 * reach, 0, 0}});
  maker.look({-2, 0.3, 0.1}, {0, 0, 0}).environment(0.5);
  maker.add(maker.emitter(300), lamp(0, 0, 0.05, 0.05, 1));
  const double factor = parallel(0.05, 0.05, 1);
  expect_mean(measure(maker.build(), {}), reflected(pi_d * (0.5 + 299.5 * factor)));
}

/// A triangle in the floor, with a normal given at each corner, looked at in its centre.
SceneMaker bent_floor(const std::array<scene::Vec3, 3>& normals) {
  SceneMaker maker;
  scene::Mesh mesh;
  mesh.positions = {{-1, 0, -1}, {0, 0, 2}, {1, 0, -1}};
  mesh.triangles = {{0, 1, 2}};
  for (const scene::Vec3& n : normals) {
    mesh.normals.push_back(
        {static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])});
  }
  maker.add(maker.diffuse(albedo), mesh);
  maker.look({-2, 0.3, 0.1}, {0, 0, 0});
  return maker;
}
/// Their mean, each as 32 bits keep it.
Vec3d mean_normal(const std::array<scene::Vec3, 3>& normals) {
  Vec3d sum;
  for (const scene::Vec3& n : normals) {
    const Vec3 unit = to_float(normalize(to_vec3d(n)));
    sum += to_double(decode_octahedral(encode_octahedral(unit)));
  }
  return normalize(sum);
}

TEST(Direct, AnInterpolatedNormalTiltsTheEnvironmentsCosine) {
  // The sky is still cut off by the ground: of a plane tilted by τ it lights (1 + cos τ)/2.
  const std::array<scene::Vec3, 3> normals{{{-0.9, 1, 0}, {-0.2, 1, 0.6}, {-0.7, 1, -0.3}}};
  SceneMaker maker = bent_floor(normals);
  maker.add(maker.diffuse(0), scene::Quad{{-1e5, -1e-3, -1e5}, {0, 0, 2e5}, {2e5, 0, 0}});
  maker.environment(2);
  const double cosine = mean_normal(normals).y;
  ASSERT_LT(cosine, 0.9);
  expect_mean(measure(maker.build(), {}), reflected(2 * pi_d * (1 + cosine) / 2));
}

TEST(Direct, AnInterpolatedNormalTiltsALampsCosine) {
  const std::array<scene::Vec3, 3> normals{{{-0.9, 1, 0}, {-0.2, 1, 0.6}, {-0.7, 1, -0.3}}};
  for (const Vec3d& towards : {Vec3d{-0.6, 0.8, 0}, Vec3d{0.48, 0.8, 0.36}}) {
    SceneMaker maker = bent_floor(normals);
    const double d = 2, radius = 0.25;
    maker.add(maker.emitter(1),
              scene::Sphere{{d * towards.x, d * towards.y, d * towards.z}, radius});
    const double cosine = dot(mean_normal(normals), towards);
    ASSERT_GT(cosine, 0.3);
    expect_mean(measure(maker.build(), {}), reflected(pi_d * radius * radius / (d * d) * cosine));
  }
}

TEST(Direct, ABlackWallHidesHalfOfTheEnvironment) {
  SceneMaker maker = floor_scene();
  maker.environment(1);
  // So large that it is half of the sky to 1e-4; that part is taken off below.
  const double c = 1, a = 1e4, b = 1e4;
  maker.add(maker.diffuse(0), scene::Quad{{c, -a, -b}, {0, 0, 2 * b}, {0, 2 * a, 0}});
  const double hidden = 2 * perpendicular(a, b, c);
  EXPECT_NEAR(hidden, 0.5, 1e-4);
  expect_mean(measure(maker.build(), {4, 1024}), reflected(pi_d * (1 - hidden)));
}

TEST(Direct, TheFloorOfTheCornellBoxUnderItsLamp) {
  SceneMaker maker;
  maker.add(maker.diffuse(albedo), scene::Quad{{0, 0, 0}, {0, 0, 559.2}, {552.8, 0, 0}});
  maker.add(maker.emitter(1), scene::Quad{{343, 548.8, 227}, {0, 0, 105}, {-130, 0, 0}});
  maker.look({278, 100, -300}, {278, 0, 279.6});
  const double factor = 0.0142070;
  EXPECT_NEAR(pi_d * factor, 0.0446325, 1e-6);
  expect_mean(measure(maker.build(), {}), reflected(0.0446325));
}

TEST(Direct, InstancedLampsShineAsMuchAsPlainOnes) {
  SceneMaker plain = floor_scene();
  const std::uint32_t glow = plain.emitter(1);
  const scene::Transform there = translate(1.5, 1, 0) * rotate({0, 0, 1}, 20);
  // A mirrored instance: its outer side must stay its outer side.
  const scene::Transform mirrored =
      translate(-1.2, 1.1, 0) * scale(-1, 1, 1) * rotate({0, 0, 1}, 30);
  scene::Mesh pane;
  pane.positions = {
      {-0.3F, 0.9F, 0.2F}, {0.1F, 0.9F, 0.2F}, {0.2F, 0.9F, 0.7F}, {-0.2F, 0.9F, 0.7F}};
  pane.triangles = {{0, 1, 2}, {0, 2, 3}};
  SceneMaker instanced = plain;
  plain.add(glow, lamp(-0.5, -0.5, 1, 1, 0), there);
  plain.add(glow, lamp(-0.5, -0.5, 1, 1, 0), mirrored);
  plain.add(glow, scene::Sphere{{0, 0.5, 0.3}, 0.1}, there);
  plain.add(glow, scene::Sphere{{0, 0.5, 0.3}, 0.1}, mirrored);
  plain.add(glow, pane, there);
  plain.add(glow, pane, mirrored);
  scene::Object object;
  object.name = "lamp";
  scene::Shape quad, ball_shape, pane_shape;
  quad.geometry = lamp(-0.5, -0.5, 1, 1, 0);
  ball_shape.geometry = scene::Sphere{{0, 0.5, 0.3}, 0.1};
  pane_shape.geometry = pane;
  quad.material = ball_shape.material = pane_shape.material = glow;
  object.shapes = {quad, ball_shape, pane_shape};
  instanced.description.objects = {object};
  instanced.description.instances = {{0, there}, {0, mirrored}};
  const Scene a = plain.build(), b = instanced.build();
  ASSERT_EQ(a.lights.size(), 6U);
  ASSERT_EQ(b.lights.size(), 6U);
  ASSERT_EQ(b.placements.size(), 3U);
  const Estimate first = measure(a, {4, 256}), second = measure(b, {4, 256});
  ASSERT_GT(first.mean, 0.01);
  EXPECT_LT(first.error, 0.004 * first.mean);
  EXPECT_NEAR(
      first.mean, second.mean,
      student_bound(23) * std::sqrt(first.error * first.error + second.error * second.error));
}

}  // namespace
}  // namespace tessera::render::proof
