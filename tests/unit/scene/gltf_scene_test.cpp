#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

#include "common/scene/object_names.hpp"
#include "tests/unit/scene/gltf_file.hpp"

namespace tessera::scene {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

Vec3 times(const Transform& t, const Vec3& p) {
  Vec3 out{};
  for (std::size_t i = 0; i < 3; ++i)
    out[i] = t.m[4 * i] * p[0] + t.m[4 * i + 1] * p[1] + t.m[4 * i + 2] * p[2] + t.m[4 * i + 3];
  return out;
}

void expect_near(const Vec3& a, const Vec3& b) {
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 1e-12) << i;
}

const nlohmann::json quarter_turn_about_y{0, 0.70710678118654752, 0, 0.70710678118654752};

TEST(GltfScene, nodes_place_what_they_hold_in_their_parents_spaces) {
  GltfFile file;
  file.with_triangle();
  file.json["nodes"][0]["translation"] = {1, 2, 3};
  file.json["nodes"].push_back(
      {{"children", {0}}, {"rotation", quarter_turn_about_y}, {"scale", {2, 2, 2}}});
  file.json["nodes"].push_back(
      {{"children", {1}}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1}}});
  file.json["scenes"][0]["nodes"] = {2};
  const LoadedScene loaded = file.load();
  ASSERT_EQ(loaded.scene.shapes.size(), 1U);
  // (1,0,0) → +(1,2,3) → ·2, z to x and x to −z → +(10,0,0)
  expect_near(times(loaded.scene.shapes[0].to_world, {1, 0, 0}), {16, 4, -4});
}

TEST(GltfScene, a_mesh_of_several_nodes_is_kept_once) {
  GltfFile file;
  file.with_triangle();
  file.node({{"mesh", 0}, {"translation", {5, 0, 0}}});
  const LoadedScene loaded = file.load();
  EXPECT_TRUE(loaded.scene.shapes.empty());
  ASSERT_EQ(loaded.scene.objects.size(), 1U);
  ASSERT_EQ(loaded.scene.instances.size(), 2U);
  EXPECT_EQ(loaded.scene.objects[0].shapes.size(), 1U);
  expect_near(times(loaded.scene.instances[1].to_world, {0, 0, 0}), {5, 0, 0});
}

TEST(GltfScene, objects_have_the_names_of_their_nodes) {
  GltfFile file;
  file.with_triangle();
  file.json["meshes"][0]["name"] = "leaf";
  file.json["nodes"][0]["name"] = "branch";
  const Scene alone = file.load().scene;
  EXPECT_THAT(object_names(alone).names, ElementsAre("branch"));
  file.node({{"mesh", 0}, {"name", "twig"}});
  file.node({{"mesh", 0}});
  const Scene scene = file.load().scene;
  const ObjectNames names = object_names(scene);
  EXPECT_THAT(names.names, ElementsAre("branch", "twig", "leaf"));
  EXPECT_EQ(names.of_instance, (std::vector<std::uint32_t>{0, 1, 2}));
}

TEST(GltfScene, copies_of_a_node_stand_where_its_accessors_say) {
  GltfFile file;
  file.with_triangle();
  file.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  file.json["nodes"][0]["translation"] = {0, 0, 7};
  file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", file.floats({1, 0, 0, 2, 0, 0}, "VEC3")},
      {"SCALE", file.floats({1, 1, 1, 3, 3, 3}, "VEC3")},
      {"ROTATION", file.floats({0, 0, 0, 1, 0, 1, 0, 0}, "VEC4")}};
  const LoadedScene loaded = file.load();
  ASSERT_EQ(loaded.scene.instances.size(), 2U);
  expect_near(times(loaded.scene.instances[0].to_world, {1, 0, 0}), {2, 0, 7});
  expect_near(times(loaded.scene.instances[1].to_world, {1, 0, 0}), {-1, 0, 7});
}

TEST(GltfScene, copies_of_a_node_share_its_name) {
  constexpr std::size_t copies = 1000;
  GltfFile file;
  file.with_triangle();
  file.json["nodes"][0]["name"] = "a name that is too long to stand within a string";
  file.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  std::vector<float> places(3 * copies);
  for (std::size_t i = 0; i < places.size(); ++i) places[i] = static_cast<float>(i);
  file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", file.floats(places, "VEC3")}};
  file.node({{"mesh", 0}, {"name", "other"}});
  const Scene scene = file.load().scene;
  ASSERT_EQ(scene.instances.size(), copies + 1);
  EXPECT_EQ(scene.instance_names.size(), 2U);
  EXPECT_LT(scene.instance_names.bytes(), 200U);
  EXPECT_EQ(name_of(scene, scene.instances[copies - 1]), name_of(scene, scene.instances[0]));
  EXPECT_EQ(name_of(scene, scene.instances[copies]), "other");
  static_assert(sizeof(Instance) < sizeof(Transform) + sizeof(std::string),
                "an instance has no text of its own");
}

TEST(GltfScene, what_is_scaled_to_nothing_is_left_out) {
  GltfFile file;
  file.with_triangle();
  file.node({{"mesh", 0}, {"scale", {1, 0, 1}}});
  const LoadedScene loaded = file.load();
  EXPECT_EQ(loaded.scene.shapes.size(), 1U);
  EXPECT_THAT(loaded.warnings, Contains(HasSubstr("/nodes/1 is scaled to something flat")));
}

TEST(GltfScene, the_file_s_own_scene_is_shown) {
  GltfFile file;
  file.with_triangle();
  file.json["nodes"].push_back({{"mesh", 0}, {"translation", {9, 0, 0}}});
  file.json["scenes"].push_back({{"nodes", {1}}});
  file.json["scene"] = 1;
  expect_near(times(file.load().scene.shapes.at(0).to_world, {0, 0, 0}), {9, 0, 0});
}

/// Every vertex is on the film, and two of its edges that lie opposite are equally near.
void expect_to_fill(const Camera& camera, const Scene& scene) {
  const auto minus = [](const Vec3& a, const Vec3& b) {
    return Vec3{a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  };
  const auto dot = [](const Vec3& a, const Vec3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  };
  const auto cross = [](const Vec3& a, const Vec3& b) {
    return Vec3{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const auto unit = [&](const Vec3& a) {
    const double size = std::sqrt(dot(a, a));
    return Vec3{a[0] / size, a[1] / size, a[2] / size};
  };
  const Vec3 forward = unit(minus(camera.target, camera.eye));
  const Vec3 right = unit(cross(forward, camera.up)), up = cross(right, forward);
  const double tan_y = std::tan(camera.fov_y_degrees / 360 * 3.14159265358979323846);
  double left = 0, low = 0, most_right = 0, high = 0;
  for (const auto& position : mesh_of(scene.shapes.at(0)).positions) {
    const Vec3 p = minus({position[0], position[1], position[2]}, camera.eye);
    const double x = dot(right, p) / (dot(forward, p) * tan_y * 16 / 9);
    const double y = dot(up, p) / (dot(forward, p) * tan_y);
    left = std::min(left, x), most_right = std::max(most_right, x);
    low = std::min(low, y), high = std::max(high, y);
  }
  EXPECT_GT(left, -1);
  EXPECT_LT(most_right, 1);
  EXPECT_GT(low, -1);
  EXPECT_LT(high, 1);
  EXPECT_GT(high - low, 1.6) << "the triangle fills the height";
  EXPECT_NEAR(high, -low, 0.1);
  EXPECT_NEAR(most_right, -left, 0.1);
}

TEST(GltfScene, a_view_of_all_and_even_light_are_made_up_and_said) {
  GltfFile file;
  file.with_triangle();
  const LoadedScene loaded = file.load();
  ASSERT_EQ(loaded.scene.cameras.size(), 1U);
  const Camera& camera = loaded.scene.cameras[0];
  expect_to_fill(camera, loaded.scene);
  EXPECT_GT(camera.eye[2], 1);
  EXPECT_NEAR(camera.least_aspect, 16.0 / 9, 0.01) << "a narrower film cuts nothing off";
  ASSERT_TRUE(loaded.scene.environment.has_value());
  EXPECT_TRUE(loaded.scene.environment->image.has_value());
  EXPECT_THAT(loaded.warnings, Contains(HasSubstr("no camera")));
  EXPECT_THAT(loaded.warnings, Contains(HasSubstr("no light")));
}

TEST(GltfScene, cameras_of_one_name_and_pictures_of_one_file_take_time_by_their_number) {
  // By its square, each of these would take minutes.
  GltfFile file;
  file.with_triangle();
  file.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}}};
  for (int i = 0; i < 30'000; ++i) {
    file.node({{"camera", 0}, {"name", i % 2 == 0 ? "eye" : "eye 2"}});
    file.json["images"].push_back({{"uri", "a.png"}});
  }
  const TemporaryFolder folder;
  folder.write("a.png", "no picture yet");
  const LoadedScene loaded = load_scene(folder.write("model.gltf", file.text()));
  std::set<std::string> names;
  for (const Camera& camera : loaded.scene.cameras) names.insert(camera.name);
  EXPECT_EQ(names.size(), 30'000U);
}

TEST(GltfScene, lights_from_blender_are_remarked_on_unless_their_units_are_said) {
  GltfFile file;
  file.with_triangle();
  file.json["extensions"]["KHR_lights_punctual"]["lights"] =
      nlohmann::json::array({{{"type", "point"}}});
  file.node({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  EXPECT_THAT(file.load().warnings, Not(Contains(HasSubstr("--units"))));
  file.json["asset"]["generator"] = "Khronos glTF Blender I/O v3.4.50";
  EXPECT_THAT(file.load().warnings, Contains(HasSubstr("--units blender")));
}

TEST(GltfScene, emission_of_one_colour_is_light_and_what_a_texture_paints_is_none) {
  GltfFile file;
  file.with_triangle();
  file.json["images"] = nlohmann::json::array({{{"uri", "data:image/png;base64,AAAA"}}});
  file.json["textures"] = nlohmann::json::array({{{"source", 0}}});
  file.json["materials"] = nlohmann::json::array({{{"emissiveFactor", {1, 1, 1}}}});
  file.json["meshes"][0]["primitives"][0]["material"] = 0;
  EXPECT_FALSE(file.load().scene.environment.has_value());
  file.json["materials"][0]["emissiveTexture"]["index"] = 0;
  EXPECT_TRUE(file.load().scene.environment.has_value());
}

TEST(GltfScene, cameras_look_along_their_nodes_minus_z) {
  GltfFile file;
  file.with_triangle();
  file.json["cameras"] = {
      {{"type", "perspective"},
       {"perspective", {{"yfov", 0.5}, {"znear", 0.1}, {"aspectRatio", 2}}}},
      {{"type", "orthographic"},
       {"orthographic", {{"xmag", 3}, {"ymag", 1.5}, {"znear", 0.1}, {"zfar", 9}}}}};
  file.node({{"camera", 0},
             {"name", "eye"},
             {"translation", {0, 1, 5}},
             {"rotation", quarter_turn_about_y}});
  file.node({{"camera", 1}, {"name", "eye"}});
  const LoadedScene loaded = file.load();
  ASSERT_EQ(loaded.scene.cameras.size(), 2U);
  const Camera &eye = loaded.scene.cameras[0], &flat = loaded.scene.cameras[1];
  EXPECT_EQ(eye.name, "eye");
  EXPECT_NEAR(eye.fov_y_degrees, 28.6478898, 1e-6);
  EXPECT_LT(eye.target[0], -1);
  EXPECT_NEAR(eye.target[2], 5, 1e-12);
  expect_near(eye.up, {0, 1, 0});
  EXPECT_EQ(flat.name, "eye 2");
  EXPECT_EQ(flat.orthographic_height, 3);
  EXPECT_EQ(loaded.scene.render.width, 2 * loaded.scene.render.height);
}

TEST(GltfScene, lights_keep_candela_and_lux_whatever_their_nodes_scale) {
  GltfFile file;
  file.with_triangle();
  file.json["extensionsUsed"] = {"KHR_lights_punctual"};
  file.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"intensity", 20}, {"color", {1, 0.5, 0}}},
      {{"type", "spot"},
       {"intensity", 5},
       {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.2}}}},
      {{"type", "directional"}},
      {{"type", "point"}, {"intensity", 0}}};
  for (int light = 0; light < 4; ++light)
    file.node({{"translation", {0, light, 0}},
               {"scale", {2, 2, 2}},
               {"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}});
  const LoadedScene loaded = file.load();
  ASSERT_EQ(loaded.scene.lights.size(), 3U) << "a dark one is none";
  EXPECT_FALSE(loaded.scene.environment.has_value());
  const auto& point = std::get<PointLight>(loaded.scene.lights[0].shape);
  EXPECT_EQ(point.intensity, (Color{20, 10, 0}));
  const auto& spot = std::get<SpotLight>(loaded.scene.lights[1].shape);
  expect_near(spot.position, {0, 1, 0});
  expect_near(spot.direction, {0, 0, -2});
  EXPECT_NEAR(spot.outer_degrees, 11.459156, 1e-6);
  const auto& sun = std::get<DirectionalLight>(loaded.scene.lights[2].shape);
  EXPECT_EQ(sun.irradiance, (Color{1, 1, 1}));
}

TEST(GltfScene, buffers_and_images_may_be_files_beside_it) {
  const TemporaryFolder folder;
  GltfFile file;
  file.with_triangle();
  file.json["buffers"][0]["uri"] = "the%20bytes.bin";
  file.json["images"] = {{{"uri", "a/map.png"}}};
  file.json["textures"] = {{{"source", 0}}};
  file.json["materials"] = {{{"emissiveTexture", {{"index", 0}}}}};
  file.json["meshes"][0]["primitives"][0]["material"] = 0;
  folder.write("m/the bytes.bin", file.bytes());
  folder.write("m/a/map.png", "no picture yet");
  const LoadedScene loaded = load_scene(folder.write("m/model.gltf", file.json.dump()));
  ASSERT_EQ(loaded.files.size(), 3U);
  EXPECT_EQ(loaded.files[0].path, "model.gltf");
  EXPECT_EQ(loaded.files[1].path, "the bytes.bin");
  EXPECT_EQ(loaded.files[2].path, "a/map.png");
  ASSERT_EQ(loaded.scene.images.size(), 2U) << "and the made up light's";
  EXPECT_EQ(std::get<FileRange>(loaded.scene.images[0].encoded).file, folder / "m/a/map.png");
}

TEST(GltfScene, buffers_may_be_data_uris) {
  const TemporaryFolder folder;
  GltfFile file;
  file.with_triangle();
  const LoadedScene loaded = load_scene(folder.write("model.gltf", file.text()));
  EXPECT_EQ(mesh_of(loaded.scene.shapes.at(0)).positions.at(1), (std::array<float, 3>{1, 0, 0}));
  EXPECT_EQ(loaded.files.size(), 1U);
}

TEST(GltfScene, extensions_that_are_not_known_are_passed_over_if_the_file_can_do_without) {
  GltfFile file;
  file.with_triangle();
  file.json["extensionsUsed"] = {"ACME_sparkles"};
  EXPECT_THAT(file.load().warnings, Contains(HasSubstr("ACME_sparkles is not supported")));
  file.json["extensionsRequired"] = {"ACME_sparkles"};
  // Which may leave out what is needed else.
  file.json["meshes"][0]["primitives"][0]["indices"] = file.indices({0, 1, 2});
  file.json["accessors"][1].erase("bufferView");
  const Error error = error_of_bytes(file.glb());
  EXPECT_EQ(error.place().key, "/extensionsRequired/0");
  EXPECT_THAT(error.message(), HasSubstr("ACME_sparkles"));
}

}  // namespace
}  // namespace tessera::scene
