#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/render/support.hpp"
#include "worker/render/integrators/integrator.hpp"
#include "worker/render/sampler.hpp"

/// What holds for every integrator: means do not depend on how light is gathered, nor on where the
/// random numbers come from.
namespace tessera::render::proof {
namespace {

constexpr int unlimited = 1000;

/// A Cornell box in small: a lamp below the ceiling, two blocks. No light stands so close to a
/// surface that its 1/r² has no bound worth the name.
Scene small_box() {
  SceneMaker maker;
  const std::uint32_t wall = maker.diffuse(0.6);
  maker.add(wall, scene::Box{{-1, -1, -1}, {1, 1, 1}});
  maker.add(wall, scene::Box{{-0.7, -1, -0.6}, {-0.2, 0.2, -0.1}});
  maker.add(maker.diffuse(0.3), scene::Box{{0.2, -1, -0.2}, {0.7, -0.4, 0.3}});
  maker.add(maker.emitter(3), scene::Quad{{-0.5, 0.9, -0.5}, {1, 0, 0}, {0, 0, 1}});
  maker.look({0, 0, 0.95}, {0, -0.1, -1}, 80);
  return maker.build();
}

using Choice = std::tuple<std::string_view, std::string_view>;

class EveryWay : public testing::TestWithParam<Choice> {};
INSTANTIATE_TEST_SUITE_P(Names, EveryWay,
                         testing::Combine(testing::ValuesIn(integrator_names()),
                                          testing::ValuesIn(sampler_names())),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param)) + "_" +
                                  std::string(std::get<1>(test.param));
                         });

TEST_P(EveryWay, LeadsToTheSameMean) {
  static const Scene scene = small_box();
  static const Estimate good = measure(scene, {12, 256, 3});
  Take take{12, 32, 3, 2};
  take.integrator = std::get<0>(GetParam());
  take.sampler = std::get<1>(GetParam());
  const Estimate estimate = measure(scene, take, 20);
  EXPECT_LT(good.error, 0.002 * good.mean);
  EXPECT_LT(estimate.error, 0.012 * estimate.mean);
  EXPECT_NEAR(estimate.mean, good.mean, student_bound(19) * std::hypot(estimate.error, good.error));
}

class EveryIntegrator : public testing::TestWithParam<std::string_view> {
 protected:
  [[nodiscard]] static Take with(Take take) {
    take.integrator = GetParam();
    return take;
  }
};
INSTANTIATE_TEST_SUITE_P(Names, EveryIntegrator, testing::ValuesIn(integrator_names()),
                         [](const auto& test) { return std::string(test.param); });

Scene sphere_furnace(double albedo) {
  SceneMaker maker;
  maker.add(maker.emitter(1, true), scene::Sphere{{0, 0, 0}, 1});
  maker.look({0.1, 0.2, 0.3}, {0.5, 0.4, -1}, 60);
  return maker.build(albedo);
}

TEST_P(EveryIntegrator, CountsBouncesAlike) {
  // 1 + ρ + ρ² + …, one term more than bounces allow scatterings; by the eighth it is nearly the
  // limit.
  const Scene scene = sphere_furnace(0.6);
  const double after[] = {1.6, 1.96, 2.176};
  for (int bounces = 0; bounces < 3; ++bounces) {
    expect_mean(measure(scene, with({8, 48, bounces})), after[bounces]);
  }
  expect_mean(measure(scene, with({8, 48, 7})), 2.4748058);
}

TEST_P(EveryIntegrator, ReachesTheFurnacesLimit) {
  // What is left after 24 bounces is beyond floats; paths that nothing else ends are ended there.
  expect_mean(measure(sphere_furnace(0.5), with({8, 32, 24})), 2);
}

TEST_P(EveryIntegrator, FollowsAMirror) {
  SceneMaker maker;
  maker.add(maker.mirror(0.7), scene::Quad{{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}});
  maker.environment(2).look({0, 0, 3}, {0, 0, 0}, 10);
  const RenderedTask done = render(maker.build(), with({4, 16, 0}), 1);
  for (const float value : done.image.plane(image::R)) EXPECT_NEAR(value, 1.4, 1e-6);
}

TEST_P(EveryIntegrator, SeesALampInAMirror) {
  // What a ray runs into after a delta is counted, by those too that sample lights.
  SceneMaker maker;
  maker.add(maker.mirror(0.5), scene::Quad{{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}});
  maker.add(maker.emitter(3), scene::Quad{{-9, -9, 6}, {0, 18, 0}, {18, 0, 0}});
  maker.look({0, 0, 3}, {0, 0, 0}, 10);
  const RenderedTask done = render(maker.build(), with({4, 16, 0}), 1);
  for (const float value : done.image.plane(image::R)) EXPECT_NEAR(value, 1.5, 1e-6);
}

TEST_P(EveryIntegrator, LooksThroughClearGlass) {
  SceneMaker maker;
  maker.add(maker.dielectric(1.5), scene::Sphere{{0, 0, 0}, 1});
  maker.environment(0.75).look({0, 0, 5}, {0, 0, 0}, 30);
  const RenderedTask done = render(maker.build(), with({32, 16, unlimited}), 3);
  for (const float value : done.image.plane(image::R)) EXPECT_NEAR(value, 0.75, 1e-5);
}

TEST_P(EveryIntegrator, SharesASurfaceBetweenADeltaAndTheRest) {
  // Half mirror, half matt, unevenly: each lobe is chosen with its share, and divided by it.
  SceneMaker maker;
  maker.add(maker.diffuse(0.2), scene::Quad{{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}});
  maker.environment(1).look({0, 0, 3}, {0, 0, 0}, 10);
  Scene scene = maker.build();
  for (CompiledMaterial& material : scene.materials) {
    Instruction coat;
    coat.lobe = {.kind = LobeKind::mirror, .weight = gray(0.6F)};
    material.program[static_cast<std::size_t>(material.count++)] = coat;
  }
  expect_mean(measure(scene, with({8, 64, 0})), 0.8);
}

TEST_P(EveryIntegrator, GivesTheFirstHitsChannelsAlike) {
  const Scene scene = small_box();
  const RenderedTask path = render(scene, {16, 4, 2}, 5);
  const RenderedTask other = render(scene, with({16, 4, 2}), 5);
  for (std::size_t c = 0; c < path.image.channels(); ++c) {
    if (c == image::R || c == image::G || c == image::B || c == image::M2_R || c == image::M2_G ||
        c == image::M2_B) {
      continue;
    }
    const auto a = path.image.plane(c), b = other.image.plane(c);
    EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin())) << "channel " << c;
  }
}

/// Direct light on a matt floor, in closed form.
struct Direct {
  const char* name;
  void (*add)(SceneMaker&);
  double expected;
};
constexpr double albedo = 0.7;
const Direct direct_cases[] = {
    {"square",
     [](SceneMaker& m) {
       m.add(m.emitter(1), scene::Quad{{-0.5, -0.5, 1}, {0, 1, 0}, {1, 0, 0}});
     },
     albedo * 0.2394565},
    {"two_sided_square",
     [](SceneMaker& m) {
       m.add(m.emitter(1, true), scene::Quad{{-1, -1, 1}, {2, 0, 0}, {0, 2, 0}});
     },
     albedo * 0.5541264},
    {"square_of_triangles",
     [](SceneMaker& m) {
       scene::Mesh mesh;
       mesh.positions = {{-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}};
       mesh.triangles = {{0, 2, 1}, {0, 3, 2}};
       m.add(m.emitter(1), mesh);
     },
     albedo * 0.5541264},
    {"sphere",
     [](SceneMaker& m) {
       m.add(m.emitter(1), scene::Sphere{{0, 0, 2}, 1});
     },
     albedo * 0.25},
    {"two_spheres_of_unlike_power",
     [](SceneMaker& m) {
       m.add(m.emitter(1), scene::Sphere{{0, 0, 2}, 0.5});
       m.add(m.emitter(9), scene::Sphere{{4, 0, 3}, 1});
     },
     albedo*(0.0625 + 9.0 / 25 * 0.6)},
    {"environment", [](SceneMaker& m) { m.environment(1); }, albedo},
};

class EveryLight : public testing::TestWithParam<std::tuple<std::string_view, Direct>> {};
INSTANTIATE_TEST_SUITE_P(Names, EveryLight,
                         testing::Combine(testing::ValuesIn(integrator_names()),
                                          testing::ValuesIn(direct_cases)),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param)) + "_" +
                                  std::get<1>(test.param).name;
                         });

TEST_P(EveryLight, LightsAFloorAsItsFormFactorSays) {
  const auto& [integrator, direct] = GetParam();
  SceneMaker maker;
  maker.add(maker.diffuse(albedo), scene::Quad{{-9, -9, 0}, {18, 0, 0}, {0, 18, 0}});
  direct.add(maker);
  maker.look({0.3, 0.1, 0.2}, {0, 0, 0});
  Take take{8, 128, 0};
  take.integrator = integrator;
  expect_mean(measure(maker.build(), take), direct.expected, 0.01);
}

}  // namespace
}  // namespace tessera::render::proof
