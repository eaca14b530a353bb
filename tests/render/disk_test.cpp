#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/support.hpp"

/// Lamps that are disks, against their form factor and against disks of triangles.
namespace tessera::render::proof {
namespace {

TEST(Disk, ADiskOfTriangles) {
  // 256 corners: its area is that of the disk to 1e-4.
  SceneMaker maker = floor_scene();
  scene::Mesh fan;
  constexpr std::uint32_t corners = 256;
  fan.positions.push_back({0, 1, 0});
  for (std::uint32_t i = 0; i < corners; ++i) {
    const double turn = 2 * pi_d * i / corners;
    fan.positions.push_back(
        {static_cast<float>(std::cos(turn)), 1, static_cast<float>(std::sin(turn))});
    fan.triangles.push_back({0, 1 + i, 1 + (i + 1) % corners});
  }
  maker.add(maker.emitter(1), fan);
  expect_mean(measure(maker.build(), {4, 1024}), reflected(pi_d / 2));
}

TEST(Disk, ACoaxialDisk) {
  for (const auto& [radius, h] : {std::pair(1.0, 1.0), std::pair(0.2, 1.0), std::pair(3.0, 0.5)}) {
    SceneMaker maker = floor_scene();
    maker.add(maker.emitter(1), scene::Disk{{0, h, 0}, {0, -1, 0}, radius});
    const Scene scene = maker.build();
    ASSERT_EQ(scene.lights.size(), 1U);
    const double expected = reflected(pi_d * radius * radius / (radius * radius + h * h));
    for (const char* integrator : {"path", "cosine", "hemisphere_lights"}) {
      const bool by_chance = std::string(integrator) == "cosine";
      if (by_chance && radius < h) continue;  // seldom found
      expect_mean(measure(scene, {4, 256, 0, 1, 2, integrator}), expected, 0.02);
    }
  }
}

TEST(Disk, ADiskThatATransformMakesAnEllipseShinesAsItsTriangles) {
  SceneMaker maker = floor_scene();
  maker.add(maker.emitter(2, true), scene::Disk{{0.1, 0, 0.2}, {0.2, -1, 0.1}, 0.5},
            translate(0, 1, 0) * scale(1.5, 1, 0.7));
  const Estimate found = measure(maker.build(), {4, 256});
  const Estimate seen = measure(maker.build(), {4, 1024, 0, 1, 2, "cosine"});
  EXPECT_NEAR(found.mean, seen.mean,
              student_bound(23) * std::sqrt(found.error * found.error + seen.error * seen.error));
  EXPECT_LT(seen.error, 0.008 * seen.mean);
}

TEST(Disk, ADiskIsSeenAsFarAsItsRim) {
  for (const double part : {0.97, 1.03}) {
    SceneMaker maker;
    maker.add(maker.emitter(1), scene::Disk{{0, 0, 0}, {0, 0, 1}, 2});
    maker.look({0, 0, 5}, {2 * part * 0.6, 2 * part * 0.8, 0});
    EXPECT_EQ(measure(maker.build(), {}).mean, part < 1 ? 1 : 0) << part;
  }
}

}  // namespace
}  // namespace tessera::render::proof
