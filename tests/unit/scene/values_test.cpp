#include <gmock/gmock.h>

#include "common/scene/names.hpp"
#include "common/scene/object_names.hpp"
#include "tests/unit/scene/support.hpp"

namespace tessera::scene {
namespace {

TEST(Scene, what_is_not_given_has_its_default) {
  const Scene scene = parse(scene_with(""));
  EXPECT_EQ(scene.render.width, 512);
  EXPECT_EQ(scene.render.height, 512);
  EXPECT_EQ(scene.render.samples, RenderSettings{}.samples);
  EXPECT_EQ(scene.render.filter, RenderSettings{}.filter);
  EXPECT_FALSE(scene.environment.has_value());
  ASSERT_EQ(scene.cameras.size(), 1U);
  EXPECT_EQ(scene.cameras[0].name, "camera");
  EXPECT_EQ(scene.cameras[0].fov_y_degrees, 40);
  EXPECT_EQ(scene.cameras[0].up, (Vec3{0, 1, 0}));
}

TEST(Scene, every_render_setting_is_taken) {
  const Scene scene = parse(scene_with(
      R"("film": {"width": 3, "height": 5, "pixel_aspect": 1.5}, "render": {"samples": 100, "bounces": 0,
    "integrator": "path", "sampler": "independent", "filter": "tent", "filter_width": 1.5, "light_samples": 4,
    "seed": 9223372036854775807, "crop": [1, 2, 2, 3],
    "clamp_direct": 5, "clamp_indirect": 0.5},)"));
  RenderSettings expected;
  expected.width = 3;
  expected.height = 5;
  expected.samples = 100;
  expected.bounces = 0;
  expected.sampler = "independent";
  expected.filter = "tent";
  expected.filter_width = 1.5;
  expected.light_samples = 4;
  expected.seed = INT64_MAX;
  expected.pixel_aspect = 1.5;
  expected.crop = Rect{1, 2, 2, 3};
  expected.clamp_direct = 5;
  expected.clamp_indirect = 0.5;
  EXPECT_EQ(scene.render, expected);
}

TEST(Scene, materials_keep_their_order_and_all_their_values) {
  const Scene scene = parse(scene_with(R"("materials": {
    "z": {"type": "diffuse", "reflectance": [0.1, 0.2, 0.3]},
    "a": {"type": "mirror", "reflectance": 0.5},
    "m": {"type": "dielectric", "ior": 1.33, "transmittance": [1, 0.5, 0.25], "reflectance": 0},
    "e": {"type": "emitter", "radiance": [1, 2, 3], "two_sided": true, "reflectance": 0.75}},)"));
  ASSERT_EQ(scene.materials.size(), 4U);
  EXPECT_EQ(scene.materials[0].name, "z");
  EXPECT_EQ(std::get<Diffuse>(scene.materials[0].surface).reflectance, (Color{0.1, 0.2, 0.3}));
  EXPECT_EQ(std::get<Mirror>(scene.materials[1].surface).reflectance, (Color{0.5, 0.5, 0.5}));
  const auto& glass = std::get<Dielectric>(scene.materials[2].surface);
  EXPECT_EQ(glass.ior, 1.33);
  EXPECT_EQ(glass.transmittance, (Color{1, 0.5, 0.25}));
  EXPECT_EQ(glass.reflectance, (Color{0, 0, 0}));
  EXPECT_EQ(std::get<Emitter>(scene.materials[3].surface).radiance, (Color{1, 2, 3}));
  EXPECT_TRUE(std::get<Emitter>(scene.materials[3].surface).two_sided);
  EXPECT_EQ(std::get<Emitter>(scene.materials[3].surface).reflectance, (Color{0.75, 0.75, 0.75}));
}

TEST(Scene, surfaces_have_all_their_values) {
  const Scene scene = parse(scene_with(R"("materials": {
    "m": {"type": "mix", "materials": ["g", "d"], "amount": 0.25, "opacity": 0.5, "back_culled": true},
    "d": {"type": "diffuse", "roughness": 0.5},
    "g": {"type": "conductor", "name": "gold", "roughness": 0.2, "anisotropy": 0.75, "anisotropy_rotation": 180},
    "c": {"type": "conductor", "eta": [1, 2, 3], "k": 4},
    "w": {"type": "dielectric", "roughness": 0.1, "attenuation_color": [0.5, 0.25, 1], "attenuation_distance": 2,
          "priority": -3},
    "t": {"type": "dielectric", "thin_walled": true},
    "p": {"type": "principled", "base_color": [0.1, 0.2, 0.3], "metallic": 0.1, "roughness": 0.2, "ior": 1.4,
          "specular": 0.3, "specular_color": [1, 2, 3], "transmission": 0.4, "thin_walled": false,
          "attenuation_color": 0.5, "attenuation_distance": 3, "clearcoat": 0.6, "clearcoat_roughness": 0.7,
          "anisotropy": 0.8, "anisotropy_rotation": 90, "emission": [4, 5, 6], "unlit": true}},)"));
  ASSERT_EQ(scene.materials.size(), 7U);
  const auto& mix = std::get<Mix>(scene.materials[0].surface);
  EXPECT_EQ(mix.first, 2U);
  EXPECT_EQ(mix.second, 1U);
  EXPECT_EQ(mix.amount.factor, 0.25);
  EXPECT_EQ(scene.materials[0].opacity.mode, Opacity::Mode::blend);
  EXPECT_EQ(scene.materials[0].opacity.alpha.factor, 0.5);
  EXPECT_TRUE(scene.materials[0].back_culled);
  EXPECT_EQ(std::get<Diffuse>(scene.materials[1].surface).roughness, 0.5);
  const auto& gold = std::get<Conductor>(scene.materials[2].surface);
  EXPECT_GT(gold.k[0], 3);
  EXPECT_EQ(gold.roughness, 0.2);
  EXPECT_EQ(gold.anisotropy, 0.75);
  EXPECT_NEAR(gold.anisotropy_rotation, 3.14159265, 1e-8);
  EXPECT_EQ(scene.materials[2].opacity.mode, Opacity::Mode::opaque);
  const auto& given = std::get<Conductor>(scene.materials[3].surface);
  EXPECT_EQ(given.eta, (Color{1, 2, 3}));
  EXPECT_EQ(given.k, (Color{4, 4, 4}));
  const auto& wine = std::get<Dielectric>(scene.materials[4].surface);
  EXPECT_EQ(wine.roughness, 0.1);
  EXPECT_EQ(wine.attenuation_color, (Color{0.5, 0.25, 1}));
  EXPECT_EQ(wine.attenuation_distance, 2);
  EXPECT_FALSE(wine.thin_walled);
  EXPECT_EQ(scene.materials[4].priority, -3);
  EXPECT_TRUE(std::get<Dielectric>(scene.materials[5].surface).thin_walled);
  const auto& all = std::get<Principled>(scene.materials[6].surface);
  EXPECT_EQ(all.base_color.factor, (Color{0.1, 0.2, 0.3}));
  EXPECT_EQ(all.metallic.factor, 0.1);
  EXPECT_EQ(all.roughness.factor, 0.2);
  EXPECT_EQ(all.ior, 1.4);
  EXPECT_EQ(all.specular.factor, 0.3);
  EXPECT_EQ(all.specular_color.factor, (Color{1, 2, 3}));
  EXPECT_EQ(all.transmission.factor, 0.4);
  EXPECT_FALSE(all.thin_walled);
  EXPECT_EQ(all.attenuation_color, (Color{0.5, 0.5, 0.5}));
  EXPECT_EQ(all.attenuation_distance, 3);
  EXPECT_EQ(all.clearcoat.factor, 0.6);
  EXPECT_EQ(all.clearcoat_roughness.factor, 0.7);
  EXPECT_EQ(all.anisotropy.factor, 0.8);
  EXPECT_NEAR(all.anisotropy_rotation, 1.57079633, 1e-8);
  EXPECT_EQ(all.emission.factor, (Color{4, 5, 6}));
  EXPECT_TRUE(all.unlit);
}

TEST(Scene, shapes_name_their_material_and_have_all_their_values) {
  const Scene scene = parse(
      scene_with(R"("materials": {"a": {"type": "diffuse"}, "b": {"type": "diffuse"}}, "shapes": [
    {"type": "quad", "material": "b", "name": "q", "corner": [1, 2, 3], "edge_u": [1, 0, 0], "edge_v": [0, 0, 2]},
    {"type": "sphere", "material": "a", "center": [4, 5, 6], "radius": 2.5},
    {"type": "disk", "material": "a", "center": [1, 2, 3], "normal": [0, -2, 0], "radius": 4},
    {"type": "box", "material": "b", "low": [-1, -2, -3], "high": [1, 2, 3]},
    {"type": "mesh", "material": "a", "positions": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "normals": [[0, 0, 1], [0, 0, 1], [0, 1, 0]],
     "uvs": [[0, 0], [1, 0], [0, 0.5]], "triangles": [[0, 1, 2], [2, 1, 0]]}],)"));
  ASSERT_EQ(scene.shapes.size(), 5U);
  EXPECT_EQ(scene.shapes[0].name, "q");
  EXPECT_EQ(scene.shapes[0].material, 1U);
  EXPECT_EQ(std::get<Quad>(scene.shapes[0].geometry).edge_v, (Vec3{0, 0, 2}));
  EXPECT_EQ(scene.shapes[1].name, "sphere 1");
  EXPECT_EQ(scene.shapes[1].material, 0U);
  EXPECT_EQ(std::get<Sphere>(scene.shapes[1].geometry).radius, 2.5);
  EXPECT_EQ(std::get<Box>(scene.shapes[3].geometry).low, (Vec3{-1, -2, -3}));
  const Mesh& mesh = std::get<Mesh>(scene.shapes[4].geometry);
  EXPECT_EQ(mesh.positions[1], (std::array<float, 3>{1, 0, 0}));
  EXPECT_EQ(mesh.normals[2], (std::array<float, 3>{0, 1, 0}));
  EXPECT_EQ(mesh.uvs[2], (std::array<float, 2>{0, 0.5}));
  EXPECT_EQ(mesh.triangles[1], (std::array<std::uint32_t, 3>{2, 1, 0}));
}

TEST(Scene, a_disk_lies_upright_in_its_square) {
  const Disk disk{{1, 2, 3}, {0, 0, 5}, 2};
  const Quad front = square_around(disk);
  EXPECT_EQ(front.corner, (Vec3{-1, 0, 3}));
  EXPECT_EQ(front.edge_u, (Vec3{4, 0, 0}));
  EXPECT_EQ(front.edge_v, (Vec3{0, 4, 0}));
  const Quad lamp = square_around({{0, 3, 0}, {0, -1, 0}, 1});
  EXPECT_EQ(lamp.edge_u, (Vec3{2, 0, 0}));
  EXPECT_EQ(lamp.edge_v, (Vec3{0, 0, 2}));
}

TEST(Scene, instances_name_their_object) {
  const Scene scene = parse(scene_with(R"("materials": {"a": {"type": "diffuse"}}, "objects": {
    "one": {"shapes": [{"type": "sphere", "material": "a"}]},
    "two": {"shapes": [{"type": "sphere", "material": "a"}, {"type": "sphere", "material": "a", "radius": 2}]}},
    "instances": [{"object": "two", "name": "tall", "transform": [{"translate": [1, 2, 3]}]}, {"object": "one"}],)"));
  ASSERT_EQ(scene.objects.size(), 2U);
  EXPECT_EQ(scene.objects[1].shapes.size(), 2U);
  ASSERT_EQ(scene.instances.size(), 2U);
  EXPECT_EQ(scene.instances[0].object, 1U);
  EXPECT_EQ(scene.instances[0].to_world.m[7], 2);
  EXPECT_EQ(scene.instances[1].object, 0U);
  EXPECT_THAT(object_names(scene).names, testing::ElementsAre("tall", "one"));
}

TEST(Scene, a_lens_and_a_film_give_the_measured_field_of_view) {
  const Scene scene =
      parse(R"({"tessera": 1, "camera": {"eye": [278, 273, -800], "target": [278, 273, 0],
    "focal_length": 0.035, "film_size": [0.036, 0.025]}})");
  EXPECT_NEAR(scene.cameras[0].fov_y_degrees, 39.30765, 1e-5);
}

TEST(Scene, cameras_without_a_name_are_numbered) {
  const Scene scene = parse(R"({"tessera": 1, "cameras": [{"eye": [0, 0, 1], "target": [0, 0, 0]},
    {"eye": [0, 0, 1], "target": [0, 0, 0]}]})");
  EXPECT_EQ(scene.cameras[0].name, "camera");
  EXPECT_EQ(scene.cameras[1].name, "camera 2");
}

TEST(Names, the_nearest_is_named_at_the_given_key) {
  try {
    check_name("filter", "gausian", {filter_names.begin(), filter_names.end()}, "filter");
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()),
              "filter: unknown filter \"gausian\"; did you mean \"gaussian\"? (expected one of: "
              "box, tent, gaussian, "
              "blackman_harris)");
  }
}

TEST(Names, the_defaults_are_names) { EXPECT_NO_THROW(check_names(RenderSettings{})); }

}  // namespace
}  // namespace tessera::scene
