#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/render/support.hpp"

/// What has no area, no light or no substance does no harm.
namespace tessera::render::proof {
namespace {

/// Corners of one mesh: a floor one by one, and a lamp two by two above it that shines down.
scene::Mesh floor_mesh() {
  scene::Mesh mesh;
  mesh.positions = {{-0.5F, 0, -0.5F}, {-0.5F, 0, 0.5F}, {0.5F, 0, 0.5F}, {0.5F, 0, -0.5F}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}
scene::Mesh lamp_mesh() {
  scene::Mesh mesh;
  mesh.positions = {{-1, 1, -1}, {1, 1, -1}, {1, 1, 1}, {-1, 1, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}
/// Faces that are points and lines, among and beside those that are there.
void add_degenerate(scene::Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.push_back({0.1F, 0.5F, 0.2F});
  mesh.positions.push_back({0.2F, 0.6F, 0.3F});
  mesh.positions.push_back({0.3F, 0.7F, 0.4F});
  for (const std::array<std::uint32_t, 3>& face :
       {std::array{0U, 0U, 0U}, {1U, 1U, 2U}, {first, first + 1, first + 2}, {2U, first, first}})
    mesh.triangles.insert(mesh.triangles.begin() + 1, face);
}

Scene lit_floor(bool degenerate_floor, bool degenerate_lamp) {
  SceneMaker maker;
  scene::Mesh floor = floor_mesh(), lamp = lamp_mesh();
  if (degenerate_floor) add_degenerate(floor);
  if (degenerate_lamp) add_degenerate(lamp);
  maker.add(maker.diffuse(0.5), floor);
  maker.add(maker.emitter(1), lamp);
  maker.look({-2, 0.3, 0.1}, {0, 0, 0});
  return maker.build();
}

/// What a lamp of 2×2 one unit above its middle gives a surface of albedo ½.
constexpr double lit = 0.5 * 0.5541264;

bool same_picture(const Scene& a, const Scene& b) {
  const Take take{.side = 16, .samples = 16, .bounces = 3};
  const image::TileImage one = render(a, take, 3).image, other = render(b, take, 3).image;
  const auto bits = [](const image::TileImage& image) {
    return std::span(image.values).first(7 * image.pixels());
  };
  return std::memcmp(bits(one).data(), bits(other).data(), bits(one).size_bytes()) == 0;
}

TEST(Degenerate, FacesWithoutAreaChangeNoBit) {
  EXPECT_TRUE(same_picture(lit_floor(true, false), lit_floor(false, false)));
}

TEST(Degenerate, FacesOfALampWithoutAreaChangeNoMean) {
  for (const char* integrator : {"path", "hemisphere_lights"})
    expect_mean(measure(lit_floor(true, true), {4, 256, 0, 1, 2, integrator}), lit, 0.02);
}

TEST(Degenerate, ALampWithoutAnyAreaGivesNothing) {
  SceneMaker maker;
  scene::Mesh line;
  line.positions = {{-1, 1, 0}, {0, 1, 0}, {1, 1, 0}};
  line.triangles = {{0, 1, 2}, {1, 1, 1}};
  maker.add(maker.diffuse(0.5), floor_mesh());
  maker.add(maker.emitter(1e6, true), line);
  maker.look({-2, 0.3, 0.1}, {0, 0, 0});
  const RenderedTask done = render(maker.build(), {16, 64, 4}, 3);
  for (const float value : done.image.plane(image::R)) ASSERT_EQ(value, 0);
  EXPECT_EQ(done.stats.rejected, 0);
}

TEST(Degenerate, WhatIsBlackTakesAllLightAndGivesNone) {
  SceneMaker maker;
  maker.add(maker.diffuse(0), floor_mesh());
  maker.add(maker.mirror(0), scene::Sphere{{0, 0.1, 0}, 0.1});
  maker.add(maker.emitter(0), scene::Quad{{-1, 0.8, -1}, {2, 0, 0}, {0, 0, 2}});
  maker.environment(3).look({-2, 0.3, 0.1}, {0, 0, 0}, 3);
  const Scene scene = maker.build();
  EXPECT_EQ(scene.lights.size(), 1U) << "what emits nothing is no light";
  for (const char* integrator : {"path", "cosine", "hemisphere", "hemisphere_lights"}) {
    const RenderedTask done = render(scene, {8, 64, 4, 1, 2, integrator}, 3);
    EXPECT_EQ(done.stats.rejected, 0);
    for (const float value : done.image.plane(image::R)) ASSERT_EQ(value, 0) << integrator;
  }
}

TEST(Degenerate, WhatIsWhollyTransparentIsNotThere) {
  const Scene bare = lit_floor(false, false);
  for (const char* type : {"diffuse", "emitter", "dielectric"}) {
    SceneMaker maker;
    maker.add(maker.diffuse(0.5), floor_mesh());
    maker.add(maker.emitter(1), lamp_mesh());
    const std::uint32_t veil = type == std::string("diffuse")   ? maker.diffuse(0.9)
                               : type == std::string("emitter") ? maker.emitter(100)
                                                                : maker.dielectric(1.5);
    scene::Opacity& opacity = maker.description.materials[veil].opacity;
    opacity.mode = scene::Opacity::Mode::blend;
    opacity.alpha.factor = 0;
    maker.add(veil, scene::Sphere{{0, 0, 0}, 0.4});
    maker.look({-2, 0.3, 0.1}, {0, 0, 0});
    expect_mean(measure(maker.build(), {4, 256, 4}), lit, 0.02);
  }
}

/// Rays of a floor under a lamp behind this many plates that are wholly transparent.
std::int64_t rays_through(int plates, bool lit_apart, const std::string& integrator) {
  SceneMaker maker;
  maker.add(maker.diffuse(0.5), floor_mesh());
  maker.add(maker.emitter(1), lamp_mesh());
  if (lit_apart) {
    maker.add(maker.diffuse(0.5), scene::Sphere{{0, 50, 0}, 0.1});
    maker.description.shapes.back().visibility.indirect = false;
  }
  const std::uint32_t veil = maker.diffuse(0.9);
  maker.description.materials[veil].opacity = {.mode = scene::Opacity::Mode::blend,
                                               .alpha = {.factor = 0}};
  for (int i = 0; i < plates; ++i)
    maker.add(veil, scene::Quad{{-3, 0.1 + 0.01 * i, -3}, {6, 0, 0}, {0, 0, 6}});
  maker.look({-2, 0.7, 0.1}, {0, 0, 0}, 10);
  return render(maker.build(), {8, 16, 0, 1, 2, integrator}, 3).stats.rays;
}

TEST(Degenerate, ARayThroughWhatIsNotThereIsOne) {
  for (const char* integrator : {"path", "cosine", "hemisphere", "hemisphere_lights"})
    for (const bool lit_apart : {false, true})
      EXPECT_EQ(rays_through(40, lit_apart, integrator), rays_through(0, lit_apart, integrator))
          << integrator << ' ' << lit_apart;
}

}  // namespace
}  // namespace tessera::render::proof
