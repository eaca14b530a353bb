#include <gtest/gtest.h>

#include <cmath>
#include <variant>
#include <vector>

#include "tests/render/support.hpp"

/// Light that is scattered many times, against closed forms.
namespace tessera::render::proof {
namespace {

constexpr int unlimited = 1000;

/// A closed room that emits 1 from every wall and reflects `albedo`, seen from inside.
enum class Room { sphere, box, mesh };
Scene furnace(Room room, double albedo, double radiance = 1) {
  SceneMaker maker;
  const std::uint32_t wall = maker.emitter(radiance, true);
  switch (room) {
    case Room::sphere:
      maker.add(wall, scene::Sphere{{0, 0, 0}, 1});
      break;
    case Room::box:
      maker.add(wall, scene::Box{{-1, -1, -1}, {1, 1, 1}});
      break;
    case Room::mesh:
      maker.add(wall, ball(2, false), rotate({1, 2, 3}, 40));
      break;
  }
  maker.look({0.1, 0.2, 0.3}, {0.5, 0.4, -1}, 60);
  return maker.build(albedo);
}

TEST(Global, ClosedFurnace) {
  for (const Room room : {Room::sphere, Room::box, Room::mesh}) {
    expect_mean(measure(furnace(room, 0.5), {8, 64, unlimited}), 2);
    expect_mean(measure(furnace(room, 0.8), {8, 64, unlimited}), 5, 0.01);
  }
}

TEST(Global, ClosedFurnaceByBounces) {
  // The table's n counts scatterings; n = bounces + 1, as the hit after the last one still shows
  // its emission.
  const Scene scene = furnace(Room::box, 0.8);
  const double after[] = {1.8, 2.44, 2.952};
  for (int bounces = 0; bounces < 3; ++bounces) {
    expect_mean(measure(scene, {8, 64, bounces}), after[bounces]);
  }
  expect_mean(measure(scene, {8, 64, 7}), 4.328911);
}

TEST(Global, SphereSeenFromInside) {
  expect_mean(measure(furnace(Room::sphere, 0.5, 0.5), {8, 64, unlimited}), 1);
  // What it emits, and what is scattered once.
  expect_mean(measure(furnace(Room::sphere, 0.5, 0.5), {8, 64, 0}), 0.75);
}

TEST(Global, AColouredFurnaceGivesEachChannelItsOwnSum) {
  Scene scene = furnace(Room::box, 0.5);
  for (CompiledMaterial& material : scene.materials) {
    for (Instruction& step : material.program) {
      if (step.code == Instruction::Code::lobe) step.lobe.weight = {0.2F, 0.5F, 0.8F};
    }
  }
  const double expected[] = {1.25, 2, 5};
  for (std::size_t channel = 0; channel < 3; ++channel) {
    std::vector<double> means;
    for (std::uint64_t seed = 0; seed < 24; ++seed) {
      const RenderedTask done = render(scene, {8, 64, unlimited}, seed);
      double sum = 0;
      for (const float value : done.image.plane(image::R + channel)) sum += value;
      means.push_back(sum / static_cast<double>(done.image.pixels()));
    }
    expect_mean(estimate_of(means), expected[channel], 0.01);
  }
}

TEST(Global, IntegratingSphereWithAPort) {
  // The port is a black disk in the plane of its rim: seen from any point of the wall it covers the
  // very part of the sphere that lies behind it, f = 2 %.
  constexpr double albedo = 0.8, port = 0.02, lamp_radius = 0.01;
  SceneMaker maker;
  maker.add(maker.diffuse(albedo), scene::Sphere{{0, 0, 0}, 1});
  // Flux 1, from the centre.
  const double radiance = 1 / (4 * pi_d * pi_d * lamp_radius * lamp_radius);
  maker.add(maker.emitter(radiance), scene::Sphere{{0, 0, 0}, lamp_radius});
  scene::Mesh disk;
  constexpr std::uint32_t corners = 512;
  const double height = 1 - 2 * port, rim = std::sqrt(1 - height * height);
  disk.positions.push_back({0, static_cast<float>(height), 0});
  for (std::uint32_t i = 0; i < corners; ++i) {
    const double turn = 2 * pi_d * i / corners;
    disk.positions.push_back({static_cast<float>(rim * std::cos(turn)), static_cast<float>(height),
                              static_cast<float>(rim * std::sin(turn))});
    disk.triangles.push_back({0, 1 + i, 1 + (i + 1) % corners});
  }
  maker.add(maker.diffuse(0), disk);
  maker.look({0.3, 0.1, 0.2}, {0.8, -0.3, 0.5}, 40);
  // Φ/(πA)·ρ/(1 − ρ(1 − f)), where the lamp, which is black, takes its part too: (r/R)².
  const double lost = port + lamp_radius * lamp_radius;
  const double expected = albedo / (4 * pi_d * pi_d) / (1 - albedo * (1 - lost));
  EXPECT_NEAR(expected, 0.0938159, 1e-4);
  expect_mean(measure(maker.build(), {8, 256, unlimited}), expected);
}

TEST(Global, AGlassSphereReflectsTheMeanOfFresnelsReflectance) {
  // From afar the sphere's disk shows each angle as often as diffuse light comes in by it. Nothing
  // passes, so the disk has what is reflected, and the corners of the film the environment.
  const struct {
    double ior, reflectance;
  } cases[] = {{1.33, 0.065931}, {1.5, 0.091778}, {1.8, 0.134054}};
  for (const auto& one : cases) {
    SceneMaker maker;
    const std::uint32_t glass = maker.dielectric(one.ior);
    std::get<scene::Dielectric>(maker.description.materials[glass].surface).transmittance = {};
    maker.add(glass, scene::Sphere{{0, 0, 0}, 1});
    constexpr double away = 2000;
    const double fov = 2 * std::asin(1 / away) * 180 / pi_d;
    maker.environment(0.75).look({0, 0, away}, {0, 0, 0}, fov, {0, 1, 0});
    const double disk = pi_d / 4;
    expect_mean(measure(maker.build(), {16, 64, unlimited}),
                0.75 * (disk * one.reflectance + (1 - disk)));
  }
}

TEST(Global, ClearGlassSphereInAConstantEnvironmentIsNotThere) {
  SceneMaker maker;
  maker.add(maker.dielectric(1.5), scene::Sphere{{0, 0, 0}, 1});
  maker.environment(0.75).look({0, 0, 5}, {0, 0, 0}, 30);
  const RenderedTask done = render(maker.build(), {32, 64, unlimited}, 3);
  for (const float value : done.image.plane(image::R)) EXPECT_NEAR(value, 0.75, 1e-5);
  for (const float value : done.image.plane(image::M2_R)) EXPECT_LT(value, 1e-9);
}

TEST(Global, AClearGlassMeshInAConstantEnvironmentIsNotThere) {
  SceneMaker maker;
  maker.add(maker.dielectric(1.5), ball(2, false));
  maker.environment(0.75).look({0, 0, 5}, {0, 0, 0}, 30);
  expect_mean(measure(maker.build(), {16, 16, unlimited}), 0.75);
}

/// Radiance through (or back from) a slab with a lamp of radiance 1 behind it (or behind the
/// camera).
Estimate slab(double lamp_z) {
  SceneMaker maker;
  maker.add(maker.dielectric(1.5), scene::Box{{-10, -10, -0.5}, {10, 10, 0.5}});
  const double turn = lamp_z > 0 ? -1 : 1;
  maker.add(maker.emitter(1), scene::Quad{{-9 * turn, -9, lamp_z}, {18 * turn, 0, 0}, {0, 18, 0}});
  maker.look({0.1, 0.2, 3}, {0.1, 0.2, 0}, 0.001, {0, 1, 0});
  return measure(maker.build(), {8, 256, unlimited});
}

TEST(Global, ASlabPassesAndReflectsByFresnelsFormula) {
  expect_mean(slab(-4), 0.923077);
  expect_mean(slab(4), 0.076923, 0.01);
}

TEST(Global, TwoLargePlatesOfWhichOneEmits) {
  // Gap 1, side 4000: the open rim is 1e-7 of what a point in the middle sees.
  constexpr double side = 4000;
  for (const bool look_down : {true, false}) {
    SceneMaker maker;
    const std::uint32_t glow = maker.emitter(1 / pi_d), gray_plate = maker.diffuse(0.8);
    maker.add(glow, scene::Quad{{-side / 2, 0, -side / 2}, {0, 0, side}, {side, 0, 0}});
    maker.add(gray_plate, scene::Quad{{-side / 2, 1, -side / 2}, {side, 0, 0}, {0, 0, side}});
    maker.look({0, 0.5, 0}, {0.2, look_down ? 0.0 : 1.0, 0.1});
    const double radiosity = look_down ? 1.666667 : 1.333333;
    expect_mean(measure(maker.build(0.5), {8, 256, unlimited}), radiosity / pi_d);
  }
}

TEST(Global, AMirrorShowsWhatStandsBeforeIt) {
  SceneMaker maker;
  maker.add(maker.mirror(0.7), scene::Quad{{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}});
  maker.environment(2).look({0, 0, 3}, {0, 0, 0}, 10);
  expect_mean(measure(maker.build(), {4, 16, 0}), 1.4);
}

TEST(Global, LightSamplesChangeTheNoiseAndNotTheMean) {
  SceneMaker maker;
  const std::uint32_t wall = maker.diffuse(0.7);
  maker.add(wall, scene::Box{{-1, -1, -1}, {1, 1, 1}});
  maker.add(maker.emitter(5), scene::Sphere{{0.3, 0.5, -0.2}, 0.15});
  maker.add(maker.dielectric(1.5), scene::Sphere{{-0.4, -0.6, -0.3}, 0.35});
  maker.look({0, 0, 0.9}, {0, 0, -1}, 70);
  const Scene scene = maker.build();
  const Estimate one = measure(scene, {16, 32, 8, 1}), four = measure(scene, {16, 32, 8, 4});
  EXPECT_LT(one.error, 0.01 * one.mean);
  EXPECT_NEAR(one.mean, four.mean,
              student_bound(23) * std::sqrt(one.error * one.error + four.error * four.error));
  // The noise of many pixels and bounces is not the light's: one point, direct light alone.
  maker.look({0, 0, 0.9}, {0.3, -1, 0});
  const Scene point = maker.build();
  EXPECT_LT(measure(point, {4, 16, 0, 4}).error, measure(point, {4, 16, 0, 1}).error);
}

}  // namespace
}  // namespace tessera::render::proof
