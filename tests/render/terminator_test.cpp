#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/render/support.hpp"

/// Where a sun grazes a smooth mesh of few faces, it is lit as the round thing that it stands for.
namespace tessera::render::proof {
namespace {

constexpr double albedo = 0.5;
constexpr int bounces_enough = 64;

/// A ball of 128 faces, seen from so far that rays are all but parallel, its film from −1 to 1. It
/// is turned so that no row of edges runs where a sun along an axis grazes it.
SceneMaker coarse_ball(double reflectance) {
  SceneMaker maker;
  maker.add(maker.diffuse(reflectance), ball(2, true), rotate({1, 2, 0.5}, 33));
  constexpr double away = 1000;
  maker.look({0, 0, away}, {0, 0, 0}, 2 * std::atan(1 / away) * 180 / pi_d, {0, 1, 0});
  return maker;
}

SceneMaker sunlit(double angle = 0) {
  SceneMaker maker = coarse_ball(albedo);
  maker.description.lights.push_back(
      {.name = "sun",
       .shape = scene::DirectionalLight{
           .direction = {-1, 0, 0}, .irradiance = {1, 1, 1}, .angle_degrees = angle}});
  return maker;
}

/// Where `column` of a film from −1 to 1 has its middle.
double middle(int column, int side) { return 2 * (column + 0.5) / side - 1; }

TEST(Terminator, ACoarseBallIsLitAsASphereIs) {
  constexpr int side = 64;
  const RenderedTask done = render(sunlit().build(), {.side = side, .samples = 16}, 1);
  const auto light = done.image.plane(image::R);
  double most = 0;
  for (int y = 0; y < side; ++y) {
    double before = 0;
    for (int x = 0; x < side; ++x) {
      const double at_x = middle(x, side), at_y = middle(y, side);
      if (at_x * at_x + at_y * at_y > 0.8 * 0.8) continue;  // the mesh's own outline
      const double found = double{light[static_cast<std::size_t>(y * side + x)]} * pi_d / albedo;
      most = std::max(most, std::abs(found - std::max(0.0, at_x)));
      // Across the terminator and its faces' edges it never darkens towards the sun.
      EXPECT_GT(found, before - 0.004) << x << ' ' << y;
      before = found;
    }
  }
  // Its faces lie within the sphere by a thirtieth; where faces hide themselves it is .086.
  EXPECT_LT(most, 0.05);
}

TEST(Terminator, AllIntegratorsSeeTheSame) {
  const Scene scene = sunlit(20).build();
  const Take take{.side = 8, .samples = 256};
  const Estimate by_path = measure(scene, take, 16);
  EXPECT_LT(by_path.error, 0.003 * by_path.mean);
  for (const char* integrator : {"cosine", "hemisphere", "hemisphere_lights"}) {
    Take other = take;
    other.integrator = integrator;
    other.samples = 512;
    const Estimate found = measure(scene, other, 16);
    const double error = std::sqrt(found.error * found.error + by_path.error * by_path.error);
    EXPECT_LT(error, 0.015 * by_path.mean) << integrator;
    EXPECT_NEAR(found.mean, by_path.mean, student_bound(30) * error) << integrator;
  }
}

TEST(Terminator, AWhiteBallInAFurnaceIsNotThere) {
  SceneMaker maker = coarse_ball(1);
  maker.environment(0.75);
  expect_mean(measure(maker.build(), {.side = 16, .samples = 64, .bounces = bounces_enough}, 16),
              0.75, 0.001);
}

TEST(Terminator, AnotherSizeOfAPowerOfTwoHasTheSameBits) {
  const auto picture = [](double factor) {
    SceneMaker maker = sunlit();
    maker.scaled(factor, {0, 0, 0});
    return render(maker.build(), {.side = 32, .samples = 4}, 1).image;
  };
  const image::TileImage one = picture(1);
  for (const double factor : {0x1p-10, 0x1p10}) {
    const image::TileImage other = picture(factor);
    EXPECT_TRUE(std::ranges::equal(one.plane(image::R), other.plane(image::R))) << factor;
  }
}

TEST(Terminator, NoLightComesIntoASmoothBall) {
  SceneMaker maker;
  maker.add(maker.diffuse(0.9), ball(1, true), rotate({1, 2, 0.5}, 33));
  maker.environment(1000).look({0, 0, 0.1}, {0.3, 0.2, -1}, 90);
  const RenderedTask done = render(maker.build(), {32, 64, 16}, 7);
  double sum = 0;
  for (const float value : done.image.plane(image::R)) sum += double{value};
  EXPECT_LT(sum / static_cast<double>(done.image.pixels()), 1000 * 1e-6);
}

TEST(Terminator, AFlatFaceWhoseNormalsAllTiltAlikeKeepsItsHorizon) {
  SceneMaker maker;
  scene::Mesh mesh;
  mesh.positions = {{-1, 0, -1}, {0, 0, 2}, {1, 0, -1}};
  mesh.triangles = {{0, 1, 2}};
  mesh.normals.assign(3, {0.6F, 0.8F, 0});
  maker.add(maker.diffuse(albedo), mesh);
  maker.look({0, 3, 0}, {0, 0, 0}, 0.001, {0, 0, -1});
  maker.description.lights.push_back(
      {.name = "sun",
       .shape = scene::DirectionalLight{.direction = {-5, 1, 0}, .irradiance = {1, 1, 1}}});
  EXPECT_EQ(measure(maker.build(), {4, 16}, 2).mean, 0);
}

}  // namespace
}  // namespace tessera::render::proof
