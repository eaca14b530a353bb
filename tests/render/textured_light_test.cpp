#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/support.hpp"

/// Light that differs from point to point and by direction: light samples find what paths find.
namespace tessera::render::proof {
namespace {

constexpr double albedo = 0.7;
/// Of the 2×2 square at height 1 over its middle (facts, case 5), and of either half of it.
constexpr double square = 0.5541264;

/// A material that emits by a picture, its texels sharp.
scene::Material shining(const scene::Color& factor) {
  scene::Principled surface;
  surface.base_color.factor = {0, 0, 0};
  surface.specular.factor = 0;
  surface.emission = {.factor = factor, .texture = scene::TextureUse{}};
  return {"picture", surface};
}

/// A floor under what `add` makes of a material that emits by `picture`.
class Lit {
 public:
  Lit(int width, const std::vector<int>& picture, const scene::Material& material) {
    maker_.add(maker_.diffuse(albedo), scene::Quad{{-9, -9, 0}, {18, 0, 0}, {0, 18, 0}});
    scene::Scene& scene = maker_.description;
    scene.images = {picture_of(width, picture)};
    scene.textures = {{.image = 0,
                       .wrap_u = scene::Wrap::clamp_to_edge,
                       .wrap_v = scene::Wrap::clamp_to_edge,
                       .nearest = true}};
    material_ = static_cast<std::uint32_t>(scene.materials.size());
    scene.materials.push_back(material);
    maker_.look({0.3, 0.1, 0.2}, {0, 0, 0});
  }
  template <class Shape>
  Lit& with(Shape shape, const scene::Transform& to_world = {}) {
    maker_.add(material_, shape, to_world);
    return *this;
  }
  /// Two instances of it, the other far away.
  Lit& placed(const scene::Quad& quad, const scene::Transform& to_world) {
    scene::Scene& scene = maker_.description;
    scene.objects = {{"lamp", {{"quad", quad, material_, {}}}}};
    scene.instances = {{0, translate(50, 50, 50) * to_world}, {0, to_world}};
    return *this;
  }
  [[nodiscard]] Scene build() const { return maker_.build(); }

 private:
  SceneMaker maker_;
  std::uint32_t material_ = 0;
};

/// u runs along x, v along −y.
const scene::Quad above{{-1, -1, 1}, {2, 0, 0}, {0, 2, 0}};

class Integrators : public testing::TestWithParam<std::string> {
 protected:
  static void expect_floor(const Scene& scene, double expected) {
    Take take{8, 128, 0};
    take.integrator = GetParam();
    expect_mean(measure(scene, take), expected, 0.015);
  }
};
INSTANTIATE_TEST_SUITE_P(Names, Integrators, testing::Values("path", "hemisphere_lights", "cosine"),
                         [](const auto& test) { return test.param; });

TEST_P(Integrators, a_half_that_is_white_lights_as_half_the_square) {
  const scene::Material material = shining({1, 1, 1});
  expect_floor(Lit(2, {0, -128}, material).with(above).build(), albedo * square / 2);
  expect_floor(Lit(1, {0, -128}, material).with(above).build(), albedo * square / 2);
}

TEST_P(Integrators, each_part_gives_its_own) {
  // Left bright, right dim: 4 + ½ halves.
  expect_floor(Lit(2, {2, -1}, shining({1, 1, 1})).with(above).build(), albedo * square / 2 * 4.5);
}

TEST_P(Integrators, instances_turned_and_mirrored_show_the_same) {
  for (const scene::Transform& turn : {rotate({0, 0, 1}, 90), scale(-1, 1, 1), scale(1, 2, 0.5)}) {
    const scene::Transform to_world = translate(0, 0, 1) * turn;
    const scene::Quad own = turn.m[5] == 2 ? scene::Quad{{-1, -0.5, 0}, {2, 0, 0}, {0, 1, 0}}
                                           : scene::Quad{{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}};
    expect_floor(Lit(2, {0, -128}, shining({1, 1, 1})).placed(own, to_world).build(),
                 albedo * square / 2);
  }
}

TEST_P(Integrators, a_sphere_white_below_lights_as_a_white_one_does) {
  // From under it no more than its lower half is seen.
  expect_floor(Lit(1, {-128, 0}, shining({1, 1, 1}))
                   .with(scene::Sphere{{0, 0, 0}, 1}, translate(0, 0, 2) * rotate({1, 0, 0}, 90))
                   .build(),
               albedo / 4);
}

TEST_P(Integrators, what_is_there_by_half_lights_by_half) {
  scene::Material half = shining({1, 1, 1});
  half.opacity = {.mode = scene::Opacity::Mode::blend, .alpha = {.factor = 0.5}};
  expect_floor(Lit(2, {0, 1}, half).with(above).build(), albedo * square / 2 * 1.5);
}

TEST_P(Integrators, what_is_culled_from_behind_lights_nothing_there) {
  scene::Material culled = shining({1, 1, 1});
  culled.back_culled = true;
  Lit lit(2, {0, 0}, culled);
  lit.with(above);
  Take take{4, 64, 0};
  take.integrator = GetParam();
  EXPECT_EQ(measure(lit.build(), take, 16).mean, 0);
}

TEST(TexturedLight, a_coat_dims_light_samples_as_it_dims_what_paths_find) {
  scene::Material coated = shining({1, 1, 1});
  auto& surface = std::get<scene::Principled>(coated.surface);
  surface.clearcoat.factor = 1;
  surface.clearcoat_roughness.factor = 0.4;
  const Scene scene = Lit(2, {1, -1}, coated).with(above).build();
  const Estimate found = measure(scene, {.side = 8, .samples = 1024, .integrator = "cosine"});
  expect_mean(measure(scene, {.side = 8, .samples = 256}), found.mean);
  EXPECT_LT(found.mean, 0.97 * albedo * square / 2 * 2.5);
}

TEST(TexturedLight, of_a_mesh_only_what_the_picture_lights_is_a_light) {
  scene::Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    const auto x = static_cast<float>(i);
    mesh.positions.insert(mesh.positions.end(), {{x, 0, 3}, {x, 1, 3}, {x + 1, 0, 3}});
    const float u = (x + 0.4F) / 8;
    mesh.uvs.insert(mesh.uvs.end(), {{u, 0.4F}, {u, 0.6F}, {u + 0.02F, 0.4F}});
    const auto first = static_cast<std::uint32_t>(3 * i);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  const Scene scene =
      Lit(8, {-128, 1, -128, -128, 3, -128, -128, -128}, shining({2, 1, 1})).with(mesh).build();
  ASSERT_EQ(scene.lights.size(), 2U);
  EXPECT_EQ(scene.lights[0].primitive, 1U);
  EXPECT_EQ(scene.lights[0].radiance, (Color{4, 2, 2}));
  EXPECT_EQ(scene.lights[1].primitive, 4U);
  EXPECT_EQ(scene.lights[1].radiance, (Color{16, 8, 8}));
  EXPECT_TRUE(scene.lights[0].varies);
}

TEST(TexturedLight, a_lights_mean_is_its_pictures_over_the_part_it_covers) {
  // A triangle over the lower left half of a chequered picture far finer than it is cut.
  std::vector<int> texels;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) texels.push_back((x + y) % 2 == 0 ? 1 : -128);
  scene::Mesh mesh;
  mesh.positions = {{0, 0, 3}, {1, 0, 3}, {0, 1, 3}};
  mesh.uvs = {{0, 1}, {1, 1}, {0, 0}};
  mesh.triangles = {{0, 1, 2}};
  const Scene scene = Lit(64, texels, shining({1, 1, 1})).with(mesh).build();
  ASSERT_EQ(scene.lights.size(), 1U);
  EXPECT_NEAR(scene.lights[0].radiance.r, 1, 0.02);
}

}  // namespace
}  // namespace tessera::render::proof
