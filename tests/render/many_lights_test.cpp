#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/render/support.hpp"
#include "tests/support/sanitized.hpp"

/// Six hundred small lamps chosen by what they do at the point have the mean of the same lamps
/// chosen by their power alone, the same everywhere.
namespace tessera::render::proof {
namespace {

SceneMaker hall() {
  SceneMaker maker;
  const std::uint32_t wall = maker.diffuse(0.6);
  maker.add(wall, scene::Quad{{-5, 0, 5}, {10, 0, 0}, {0, 0, -10}});
  maker.add(wall, scene::Box{{-2, 0, -2}, {-1, 1.5, -1}});
  maker.add(wall, scene::Box{{0.5, 0, 0.5}, {2, 0.8, 1.5}});
  std::mt19937 random(600);
  const auto number = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 8U) * 0x1p-24;
  };
  const std::uint32_t weak = maker.emitter(20), strong = maker.emitter(120, true);
  for (int i = 0; i < 600; ++i) {
    const double x = number(-4.5, 4.5), y = number(2.5, 3.5), z = number(-4.5, 4.5);
    const std::uint32_t glow = i % 7 == 0 ? strong : weak;
    if (i % 3 == 0) maker.add(glow, scene::Sphere{{x, y, z}, 0.02});
    if (i % 3 == 1) maker.add(glow, scene::Quad{{x, y, z}, {0.04, 0, 0}, {0, 0.01, 0.04}});
    if (i % 3 == 2) maker.add(glow, scene::Disk{{x, y, z}, {0.3, -1, 0.1}, 0.02});
  }
  maker.look({0, 2.2, 4.8}, {0, 0, 1}, 50);  // from below the lamps
  return maker;
}

TEST(ManyLights, ChosenByWhatTheyDoHaveTheMeanOfThoseChosenByPower) {
  Scene scene = hall().build();
  ASSERT_EQ(scene.lights.size(), 600U);
  const int replicates = 16;
  const Take take{.side = 24, .samples = sanitized ? 16 : 32, .bounces = 1};
  const Estimate chosen = measure(scene, take, replicates);
  scene.lights = LightTable(scene.lights.lights(), LightTable::Choice::by_power);
  Take by_power = take;
  by_power.light_samples = 4;
  const Estimate reference = measure(scene, by_power, replicates);
  const double error = std::sqrt(chosen.error * chosen.error + reference.error * reference.error);
  EXPECT_LT(error, 0.01 * reference.mean) << "too noisy to say anything";
  EXPECT_NEAR(chosen.mean, reference.mean, student_bound(2 * (replicates - 1)) * error);
}

}  // namespace
}  // namespace tessera::render::proof
