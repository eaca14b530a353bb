#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/render/support.hpp"

/// A picture does not know how large its scene is, nor where it stands.
namespace tessera::render::proof {
namespace {

/// Walls of a room from −1 to 1, with a window in the left one and a lamp behind the ceiling's
/// middle.
void add_walls(SceneMaker& maker) {
  const std::uint32_t wall = maker.diffuse(0.7);
  maker.add(wall, scene::Quad{{-1, -1, 1}, {2, 0, 0}, {0, 0, -2}});  // the floor
  maker.add(wall, scene::Quad{{-1, 1, -1}, {2, 0, 0}, {0, 0, 2}});   // the ceiling
  maker.add(wall, scene::Quad{{-1, -1, -1}, {2, 0, 0}, {0, 2, 0}});  // at the back
  maker.add(wall, scene::Quad{{1, -1, 1}, {-2, 0, 0}, {0, 2, 0}});   // behind the camera
  maker.add(wall, scene::Quad{{1, -1, -1}, {0, 0, 2}, {0, 2, 0}});   // at the right
  maker.add(wall, scene::Box{{-1.125, -1, -1}, {-1, -0.25, 1}});     // below the window …
  maker.add(wall, scene::Box{{-1.125, 0.625, -1}, {-1, 1, 1}});      // … above,
  maker.add(wall, scene::Box{{-1.125, -0.25, -1}, {-1, 0.625, -0.5}});
  maker.add(wall, scene::Box{{-1.125, -0.25, 0.25}, {-1, 0.625, 1}});  // … and beside it
}

/// Lamps of all shapes, a bulb and a spot without any; the sky and a sun beyond the window.
void add_lights(SceneMaker& maker) {
  maker.add(maker.emitter(5), scene::Quad{{-0.3, 0.96875, -0.3}, {0.6, 0, 0}, {0, 0, 0.6}});
  maker.add(maker.emitter(4), scene::Disk{{0.9375, 0.2, 0}, {-1, 0, 0}, 0.2});
  maker.add(maker.emitter(20), scene::Sphere{{-0.5, 0.3, -0.5}, 0.05});
  maker.add(maker.emitter(9), ball(1, false),
            translate(0.5, 0.4, -0.6) * rotate({1, 2, 0.5}, 33) * scale(0.1, 0.1, 0.1));
  maker.environment(2);
  maker.description.lights.push_back(
      {.name = "sun",
       .shape = scene::DirectionalLight{
           .direction = {1, -0.6, -0.2}, .irradiance = {6, 6, 6}, .angle_degrees = 0.53}});
  maker.description.lights.push_back(
      {.name = "bulb", .shape = scene::PointLight{{0.7, 0.7, 0.6}, {0.3, 0.3, 0.3}}});
  maker.description.lights.push_back(
      {.name = "spot", .shape = scene::SpotLight{{0, 0.9, 0.8}, {0, -1, -1.2}, {1, 1, 1}, 10, 25}});
}

/// All kinds of shapes and lights in a room, and light that comes in by a window, seen through a
/// lens. Not in it is what has lengths or powers of its own, which no transform scales: glass that
/// absorbs, bump maps, pictures of surroundings, which stand still.
SceneMaker room() {
  SceneMaker maker;
  add_walls(maker);
  add_lights(maker);
  maker.add(maker.dielectric(1.5), scene::Sphere{{-0.4, -0.6, -0.3}, 0.35});
  maker.add(maker.mirror(0.9), scene::Box{{0.3, -0.9, -0.8}, {0.6, -0.2, -0.5}});
  maker.add(maker.diffuse(0.4), ball(3, true), translate(0.4, -0.6, 0.1) * scale(0.3, 0.3, 0.3));
  scene::Principled paint;
  paint.roughness.factor = 0.35;
  maker.description.materials.push_back({"paint", paint});
  const auto painted = static_cast<std::uint32_t>(maker.description.materials.size() - 1);
  maker.add(painted, scene::Disk{{0.1, 0, -0.96875}, {0, 0, 1}, 0.4});
  maker.add(painted, ball(2, true), translate(-0.1, -0.8, 0.4) * scale(0.25, 0.125, 0.125));
  scene::Object pair;
  pair.name = "pair";
  scene::Shape part;
  part.geometry = ball(2, false);
  part.material = maker.diffuse(0.6);
  pair.shapes = {part};
  maker.description.objects = {pair};
  maker.description.instances = {{0, translate(0, -0.7, 0.3) * scale(0.125, 0.25, 0.125)},
                                 {0, translate(0.125, -0.7, -0.25) * scale(0.125, 0.25, 0.125)}};
  maker.look({0, 0, 0.95}, {0, 0, -1}, 70);
  maker.description.cameras[0].lens = {.radius = 0.03, .focus_distance = 1.5, .blades = 5};
  return maker;
}

const Take take{.side = 24, .samples = 16, .bounces = 6};

/// R, G, B, A and second moments, and what is no length of the rest.
std::vector<float> values_of(const SceneMaker& maker) {
  const image::TileImage image = render(maker.build(), take, 11).image;
  const std::size_t kept = (image::M2_B + 1) * image.pixels();
  return {image.values.begin(), image.values.begin() + static_cast<std::ptrdiff_t>(kept)};
}

TEST(Scale, ByAPowerOfTwoChangesNoBit) {
  const std::vector<float> as_it_is = values_of(room());
  for (const double factor : {0x1p-10, 0x1p-3, 0x1p10}) {
    SceneMaker maker = room();
    maker.scaled(factor, {0, 0, 0});
    const std::vector<float> scaled = values_of(maker);
    std::size_t different = 0;
    for (std::size_t i = 0; i < scaled.size(); ++i)
      different += std::memcmp(&scaled[i], &as_it_is[i], sizeof(float)) != 0 ? 1 : 0;
    EXPECT_EQ(different, 0U) << "of " << scaled.size() << " values, by " << factor;
  }
}

Estimate measure_mean(const SceneMaker& maker) {
  constexpr int replicates = 16;
  return measure(maker.build(), {.side = 16, .samples = 16, .bounces = 6}, replicates);
}

/// Student's test of two means; both must be told well enough to say something.
void expect_same_mean(const Estimate& a, const Estimate& b, const char* what) {
  const double error = std::sqrt(a.error * a.error + b.error * b.error);
  EXPECT_LT(error, 0.015 * a.mean) << what;
  EXPECT_NEAR(b.mean, a.mean, student_bound(2 * (a.replicates - 1)) * error) << what;
}

TEST(Scale, ByAnyFactorChangesNoMean) {
  const Estimate as_it_is = measure_mean(room());
  for (const double factor : {1e-3, 0.3, 1e3}) {
    SceneMaker maker = room();
    maker.scaled(factor, {0, 0, 0});
    expect_same_mean(as_it_is, measure_mean(maker), "scaled");
  }
}

TEST(Scale, NorDoesItMatterWhereTheSceneStands) {
  const Estimate as_it_is = measure_mean(room());
  for (const scene::Vec3& shift : {scene::Vec3{20, -7, 9}, scene::Vec3{1e5, 2e5, -3e5}}) {
    SceneMaker maker = room();
    maker.scaled(1, shift);
    expect_same_mean(as_it_is, measure_mean(maker), "moved");
  }
  SceneMaker turned = room();
  turned.moved(translate(3, -2, 5) * rotate({1, 2, 0.5}, 50));
  expect_same_mean(as_it_is, measure_mean(turned), "turned");
  // By a transform alone, with something else far off, so that no origin takes it back.
  SceneMaker maker = room();
  maker.scaled(1, {300, 0, -200});
  maker.add(maker.diffuse(0.5), scene::Sphere{{-300, 0, 200}, 1});
  expect_same_mean(as_it_is, measure_mean(maker), "far from the origin");
}

}  // namespace
}  // namespace tessera::render::proof
