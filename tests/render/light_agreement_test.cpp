#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "tests/render/support.hpp"
#include "worker/render/interaction.hpp"

/// What a light sample aims at is what a path in that direction finds, and both say the same
/// density: of every kind of light, alone, in an object that is placed twice, and painted.
namespace tessera::render::proof {
namespace {

/// Nothing hides anything from the places that are asked.
SceneMaker lamps() {
  SceneMaker maker;
  const std::uint32_t glow = maker.emitter(3, true);
  scene::Principled painted;
  painted.emission = {.factor = {2, 2, 2}, .texture = scene::TextureUse{}};
  maker.description.images = {picture_of(2, {1, -1, 0, 3})};
  maker.description.textures = {{.image = 0}};
  maker.description.materials.push_back({"painted", painted});
  const std::uint32_t picture = glow + 1;

  maker.add(glow, scene::Quad{{3, -1, -1}, {0, 0, 1.5}, {0, 1.2, 0}});
  maker.add(picture, scene::Quad{{-3, -1, -1}, {0, 0, 1.5}, {0, 1.2, 0.4}});
  maker.add(picture, scene::Sphere{{0, 3, 0.5}, 0.4});
  maker.add(glow, scene::Disk{{0.5, -3, 0.2}, {0.1, 1, 0.2}, 0.6});
  maker.add(glow,
            scene::Mesh{.positions = {{1, 1, 3}, {1.6F, 1, 3}, {1.5F, 1.7F, 3.2F}, {1, 1.6F, 3}},
                        .triangles = {{0, 1, 2}, {0, 2, 3}}});
  scene::Shape disk, round, mesh;
  disk.geometry = scene::Disk{{0, 0, 0}, {0, 0, 1}, 0.4};
  round.geometry = scene::Sphere{{1.5, 0, 0}, 0.2};
  mesh.geometry = scene::Mesh{.positions = {{0, 1, 0}, {0.5F, 1, 0}, {0, 1.5F, 0.2F}},
                              .triangles = {{0, 1, 2}}};
  disk.material = round.material = mesh.material = glow;
  maker.description.objects = {{"lamp", {disk, round, mesh}}};
  maker.description.instances = {
      {0, translate(-1, -0.5, -4) * rotate({0, 1, 0}, 20)},
      {0, translate(1.5, 1.5, -6) * rotate({1, 0, 0}, 40) * scale(-0.8, 0.8, 0.8)}};
  maker.description.lights.push_back(
      {.name = "sun",
       .shape = scene::DirectionalLight{
           .direction = {3, -4, 1}, .irradiance = {2, 2, 2}, .angle_degrees = 9}});
  return maker;
}

/// The density of light samples along a direction in which a path finds `light`; 0 where it finds
/// another.
float found_density(const Scene& scene, const LightContext& context, const LightSample& drawn) {
  Ray ray;
  ray.origin = context.p;
  ray.direction = drawn.wi;
  ray.t_max = std::numeric_limits<float>::infinity();
  const accel::Hit hit = scene.intersect(ray);
  if (!hit.any())
    return std::isinf(drawn.distance)
               ? scene.lights.pdf(context, drawn.light, {.wi = drawn.wi, .distance = ray.t_max})
               : 0;
  const Interaction at = surface_at(scene, ray, hit);
  if (at.light != drawn.light) return 0;
  EXPECT_NEAR(at.t / drawn.distance, 1, 2e-3F);
  return scene.lights.pdf(
      context, at.light,
      {.wi = drawn.wi, .distance = at.t, .instance = at.instance, .primitive = at.primitive});
}

void expect_agreement(const Scene& scene) {
  std::mt19937 random(3);
  const auto number = [&] { return static_cast<float>(random() >> 8U) * 0x1p-24F; };
  const LightContext places[] = {{.p = {0, 0, 0}},
                                 {.p = {0.3F, 0.2F, -0.4F}, .n = normalize(Vec3{1, 1, -1})},
                                 {.p = {-0.5F, 0.1F, 0.6F}, .n = {0, 0, -1}}};
  constexpr int draws = 40'000;
  std::set<std::uint32_t> seen;
  for (const LightContext& context : places) {
    std::vector<double> observed(scene.lights.size(), 0.0);
    int missed = 0;
    for (int i = 0; i < draws; ++i) {
      const auto bits = static_cast<std::uint32_t>(random());
      const float u = number();
      const float v = number();
      const LightTable::Pick pick = scene.lights.pick(context, bits);
      if (pick.pmf > 0) observed.at(pick.light) += 1;
      const LightSample drawn = scene.lights.sample(context, bits, {u, v});
      if (!drawn) continue;
      seen.insert(drawn.light);
      const float density = found_density(scene, context, drawn);
      // At a light's very rim rounding decides, and what stands before the sky hides it.
      if (!(density > 0)) {
        missed += std::isinf(drawn.distance) ? 0 : 1;
        continue;
      }
      EXPECT_NEAR(density / drawn.pdf, 1, 4e-3F) << "light " << drawn.light;
    }
    EXPECT_LT(missed, draws / 1000);
    for (std::uint32_t light = 0; light < scene.lights.size(); ++light) {
      const double expected = draws * double{scene.lights.pmf(context, light)};
      // 4.5 standard deviations: some 1e-5 for each.
      EXPECT_NEAR(observed[light], expected, 4.5 * std::sqrt(expected) + 1e-3) << light;
    }
  }
  EXPECT_EQ(seen.size(), scene.lights.size()) << "each is sampled from somewhere";
}

TEST(Lights, AreFoundWhereSamplesAimAndAsDensely) { expect_agreement(lamps().build()); }

TEST(Lights, AreFoundUnderAPictureOfTheSky) {
  SceneMaker maker = lamps();
  maker.description.images.push_back(picture_of(4, {0, 1, -1, 2, 3, -2, 0, 0}));
  maker.description.environment = scene::Environment{.radiance = {1, 1, 1}, .image = 1};
  expect_agreement(maker.build());
}

TEST(Lights, AreFoundUnderAConstantSky) {
  SceneMaker maker = lamps();
  maker.environment(1);
  expect_agreement(maker.build());
}

}  // namespace
}  // namespace tessera::render::proof
