#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "tests/render/support.hpp"
#include "tests/support/sanitized.hpp"

/// Materials in whole scenes: media, layers, surfaces that are not wholly there.
namespace tessera::render::proof {
namespace {

constexpr int unlimited = 1000;

std::uint32_t add(SceneMaker& maker, scene::Material material) {
  material.name = "m" + std::to_string(maker.description.materials.size());
  maker.description.materials.push_back(std::move(material));
  return static_cast<std::uint32_t>(maker.description.materials.size() - 1);
}
std::uint32_t add_surface(SceneMaker& maker, decltype(scene::Material::surface) surface) {
  scene::Material material;
  material.surface = std::move(surface);
  return add(maker, std::move(material));
}

/// A lamp of radiance 1 behind a slab 1 thick (or behind the camera), seen straight on.
Estimate through_slab(const scene::Dielectric& glass, double lamp_z) {
  SceneMaker maker;
  maker.add(add_surface(maker, glass), scene::Box{{-10, -10, -0.5}, {10, 10, 0.5}});
  const double turn = lamp_z > 0 ? -1 : 1;
  maker.add(maker.emitter(1), scene::Quad{{-9 * turn, -9, lamp_z}, {18 * turn, 0, 0}, {0, 18, 0}});
  maker.look({0.1, 0.2, 3}, {0.1, 0.2, 0}, 0.001, {0, 1, 0});
  return measure(maker.build(), {8, 256, unlimited});
}

TEST(Materials, AnAbsorbingSlabPassesAndReflectsWhatItShould) {
  const struct {
    double sigma, passed, reflected;
  } cases[] = {{0.5, 0.559308, 0.053569}, {1, 0.339111, 0.044990}};
  for (const auto& one : cases) {
    scene::Dielectric glass;
    glass.attenuation_distance = 2;
    const double left = std::exp(-2 * one.sigma);
    glass.attenuation_color = {left, left, left};
    expect_mean(through_slab(glass, -4), one.passed);
    expect_mean(through_slab(glass, 4), one.reflected, 0.01);
  }
}

TEST(Materials, APanePassesAndReflectsAsASlabDoes) {
  for (const bool principled : {false, true}) {
    SceneMaker maker;
    scene::Dielectric pane;
    pane.thin_walled = true;
    scene::Principled sheet;
    sheet.base_color.factor = {1, 1, 1};
    sheet.roughness.factor = 0;
    sheet.transmission.factor = 1;
    const std::uint32_t material =
        principled ? add_surface(maker, sheet) : add_surface(maker, pane);
    maker.add(material, scene::Quad{{-10, -10, 0}, {20, 0, 0}, {0, 20, 0}});
    maker.add(maker.emitter(1), scene::Quad{{-9, -9, -4}, {18, 0, 0}, {0, 18, 0}});
    maker.look({0.1, 0.2, 3}, {0.1, 0.2, 0}, 0.001, {0, 1, 0});
    // glTF's sheet has one face.
    expect_mean(measure(maker.build(), {8, 256, unlimited}), principled ? 0.96 : 0.923077);
  }
}

/// Radiance from a thing in a constant environment of 1, no limit of bounces.
Estimate in_furnace(decltype(scene::Material::surface) surface, std::int64_t samples = 64) {
  SceneMaker maker;
  maker.add(add_surface(maker, std::move(surface)), scene::Sphere{{0, 0, 0}, 1});
  maker.environment(1).look({0, 0, 5}, {0, 0, 0}, 20);
  return measure(maker.build(), {16, samples, unlimited}, 16);
}
/// Within `part` of 1.
void expect_white(const Estimate& estimate, double part, const char* what) {
  EXPECT_LT(estimate.error, 0.3 * part) << what;
  EXPECT_NEAR(estimate.mean, 1, part) << what;
}

TEST(Materials, WhatIsWhiteIsNotSeenInAFurnace) {
  // Under a sanitizer this takes minutes, and one roughness goes through the same code.
  for (const double roughness : sanitized ? std::vector{0.2} : std::vector{0.0, 0.2, 0.5, 1.0}) {
    scene::Dielectric glass;
    glass.roughness = roughness;
    expect_white(in_furnace(glass, 256), 0.005, "glass");
    glass.thin_walled = true;
    expect_white(in_furnace(glass), 0.005, "pane");
    scene::Diffuse plaster;
    plaster.reflectance = {1, 1, 1};
    plaster.roughness = roughness;
    expect_white(in_furnace(plaster), 0.005, "plaster");
    scene::Principled all;
    all.base_color.factor = {1, 1, 1};
    all.roughness.factor = roughness;
    expect_white(in_furnace(all), 0.005, "plastic");
    all.clearcoat.factor = 0.7;
    all.clearcoat_roughness.factor = 0.3;
    all.metallic.factor = 0.5;
    expect_white(in_furnace(all), 0.005, "varnished, half metal");
    all.transmission.factor = 0.6;
    expect_white(in_furnace(all), 0.005, "thin and varnished");
    all.thin_walled = false;
    all.clearcoat.factor = 0;
    // What is caught inside makes it noisy.
    expect_mean(in_furnace(all, 256), 1, 0.004);
  }
}

TEST(Materials, WaterInGlassIsInvisibleInAFurnaceAndItsInterfaceReflectsLittle) {
  // The water reaches into the glass, which counts for more: the interface is where the glass ends.
  const auto tumbler = [](bool reversed) {
    SceneMaker maker;
    scene::Material glass, water;
    glass.surface = scene::Dielectric{};
    glass.priority = reversed ? 0 : 2;
    water.surface = scene::Dielectric{.ior = 1.33};
    water.priority = 1;
    const std::uint32_t of_glass = add(maker, glass), of_water = add(maker, water);
    maker.add(of_glass, scene::Box{{-10, -10, 0}, {10, 10, 1}});
    maker.add(of_water, scene::Box{{-10, -10, -1}, {10, 10, 0.25}});
    return maker;
  };
  SceneMaker furnace = tumbler(false);
  furnace.environment(0.75).look({0.3, 0.2, 5}, {0, 0, 0}, 60);
  const RenderedTask done = render(furnace.build(), {16, 64, unlimited}, 3);
  for (const float value : done.image.plane(image::R)) EXPECT_NEAR(value, 0.75, 1e-4);

  // Straight through all of it: three interfaces, of which the middle one reflects .0036. R and T
  // of a stack of parallel interfaces add up as T = 1 / (1 + Σ r/(1 − r)).
  const auto odds = [](double a, double b) {
    const double root = (a - b) / (a + b), r = root * root;
    return r / (1 - r);
  };
  const double passed = 1 / (1 + odds(1.5, 1) + odds(1.5, 1.33) + odds(1.33, 1));
  for (const bool reversed : {false, true}) {
    SceneMaker maker = tumbler(reversed);
    maker.add(maker.emitter(1), scene::Quad{{-9, -9, -4}, {18, 0, 0}, {0, 18, 0}});
    maker.look({0.1, 0.2, 4}, {0.1, 0.2, 0}, 0.001, {0, 1, 0});
    expect_mean(measure(maker.build(), {8, 256, unlimited}), passed, 0.002);
  }
  // And that .0036 by itself: a lamp hangs in the glass and shines down, the eye sees it by the
  // interface alone, as the water swallows what passes. On its way out through the glass's upper
  // face .96 of the light is left, and its radiance is squeezed.
  for (const bool reversed : {false, true}) {
    SceneMaker maker = tumbler(reversed);
    auto& water = std::get<scene::Dielectric>(maker.description.materials[1].surface);
    water.attenuation_color = {0, 0, 0};
    water.attenuation_distance = 0.01;
    const double up_and_out = 0.96 / (1.5 * 1.5);
    maker.add(maker.emitter(1 / up_and_out), scene::Quad{{0.035, -9, 0.5}, {0, 18, 0}, {9, 0, 0}});
    maker.look({-3 * std::tan(4 * pi_d / 180), 0, 4}, {0, 0, 1}, 0.001, {0, 1, 0});
    const Estimate reflected = measure(maker.build(), {8, 1024, unlimited});
    EXPECT_LT(reflected.error, 0.004 * 0.0036);
    EXPECT_NEAR(reflected.mean, 0.0036, 0.02 * 0.0036) << reversed;
  }
}

TEST(Materials, AVeilIsThereByItsShareForPathsAndForLightSamples) {
  scene::Material veil;
  veil.surface = scene::Diffuse{{0, 0, 0}};
  veil.opacity.mode = scene::Opacity::Mode::blend;
  veil.opacity.alpha.factor = 0.4;
  // Seen through: a sphere hides by both of its sides.
  SceneMaker before;
  before.add(add(before, veil), scene::Sphere{{0, 0, 0}, 1});
  before.environment(1).look({0, 0, 5}, {0, 0, 0}, 5);
  expect_mean(measure(before.build(), {8, 256, unlimited}), 0.36);
  // Between a lamp and a floor; by each integrator.
  for (const char* integrator : {"path", "cosine", "hemisphere_lights", "hemisphere"}) {
    SceneMaker maker;
    maker.add(maker.diffuse(0.5), scene::Quad{{-0.5, 0, -0.5}, {0, 0, 1}, {1, 0, 0}});
    maker.add(add(maker, veil), scene::Quad{{-50, 0.5, -50}, {0, 0, 100}, {100, 0, 0}});
    maker.add(maker.emitter(1), scene::Quad{{-1, 1, -1}, {2, 0, 0}, {0, 0, 2}});
    maker.look({-2, 0.3, 0.1}, {0, 0, 0});
    Take take{4, 256};
    take.integrator = integrator;
    expect_mean(measure(maker.build(), take), 0.6 * 0.5 * 0.5541264, 0.02);
  }
}

TEST(Materials, WhatIsCulledFromBehindIsSeenFromTheFrontAlone) {
  scene::Material sheet;
  sheet.surface = scene::Emitter{{2, 2, 2}, true, {0, 0, 0}};
  sheet.back_culled = true;
  for (const double from : {5.0, -5.0}) {
    SceneMaker maker;
    maker.add(add(maker, sheet), scene::Quad{{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}});
    maker.environment(0.5).look({0, 0, from}, {0, 0, 0}, 5);
    expect_mean(measure(maker.build(), {4, 16, unlimited}), from > 0 ? 2 : 0.5);
  }
}

TEST(Materials, AMixIsTheMeanOfItsParts) {
  SceneMaker maker;
  scene::Conductor gold;
  gold.roughness = 0.4;
  const std::uint32_t first = add_surface(maker, gold);
  const std::uint32_t second = add_surface(maker, scene::Diffuse{{0.3, 0.3, 0.3}, 0.5});
  const std::uint32_t mixed =
      add_surface(maker, scene::Mix{first, second, {.factor = 0.25, .texture = {}}});
  const auto seen = [&](std::uint32_t material) {
    SceneMaker one = maker;
    one.add(material, scene::Quad{{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}});
    one.add(one.emitter(3), scene::Quad{{0.5, -1, 1}, {0, 0, 1}, {0, 2, 0}});
    one.environment(0.5).look({-1, 0.3, 2}, {0, 0, 0});
    return measure(one.build(), {4, 256, unlimited});
  };
  const double expected = 0.75 * seen(first).mean + 0.25 * seen(second).mean;
  expect_mean(seen(mixed), expected, 0.01);
}

TEST(Materials, ALampWithinFrostedGlassIsDimmedAlikeByPathsAndLightSamples) {
  // Seen from outside, and from within: what leads through the rough interface is found both ways.
  scene::Dielectric glass;
  glass.roughness = 0.6;
  glass.attenuation_color = {0.3, 0.3, 0.3};
  glass.attenuation_distance = 1;
  const auto seen = [&](const char* integrator) {
    SceneMaker maker;
    maker.add(add_surface(maker, glass), scene::Sphere{{0, 0, 0}, 1});
    maker.add(maker.emitter(1), scene::Sphere{{0.2, 0, 0}, 0.4});
    maker.environment(0).look({0, 0, 5}, {0, 0, 0}, 18);
    Take take{8, 512, 6};
    take.integrator = integrator;
    return measure(maker.build(), take);
  };
  const Estimate path = seen("path"), cosine = seen("cosine");
  EXPECT_LT(path.error, 0.01 * path.mean);
  EXPECT_LT(cosine.error, 0.01 * cosine.mean);
  EXPECT_NEAR(path.mean, cosine.mean,
              student_bound(23) * std::sqrt(path.error * path.error + cosine.error * cosine.error));
}

TEST(Materials, AnOpenDielectricUnderASkyGivesNumbers) {
  SceneMaker maker;
  scene::Dielectric water;
  water.roughness = 0.3;
  maker.add(add_surface(maker, water), scene::Quad{{-10, 0, -10}, {0, 0, 20}, {20, 0, 0}});
  maker.add(maker.diffuse(0.5), scene::Sphere{{0, -1, 0}, 0.5});
  maker.environment(1).look({0, 3, 3}, {0, -0.5, 0}, 40);
  for (const char* integrator : {"path", "hemisphere_lights"}) {
    Take take{16, 16, 8};
    take.integrator = integrator;
    const RenderedTask done =
        render(maker.build(), take, 1);  // expects that no sample was rejected
    EXPECT_GT(done.image.plane(image::R)[0], 0);
  }
}

TEST(Materials, UnlitIsShownAsItIs) {
  scene::Principled sign;
  sign.base_color.factor = {0.25, 0.25, 0.25};
  sign.unlit = true;

  SceneMaker maker;
  maker.add(add_surface(maker, sign), scene::Sphere{{0, 0, 0}, 1});
  maker.environment(3).look({0, 0, 5}, {0, 0, 0}, 5);
  expect_mean(measure(maker.build(), {4, 16, unlimited}), 0.25);
}

}  // namespace
}  // namespace tessera::render::proof
