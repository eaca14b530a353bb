#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/scene/object_names.hpp"
#include "tests/unit/scene/gltf_file.hpp"
#include "tests/unit/scene/support.hpp"

namespace tessera::scene {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

/// A red triangle on a node, with a camera and a light, in a folder of its own.
void write_part(const TemporaryFolder& folder) {
  GltfFile file;
  file.with_triangle();
  file.json["images"] = {{{"uri", "map.png"}}};
  file.json["textures"] = {{{"source", 0}}};
  file.json["materials"] = {
      {{"name", "red"},
       {"pbrMetallicRoughness",
        {{"baseColorFactor", {1, 0, 0, 1}}, {"baseColorTexture", {{"index", 0}}}}}}};
  file.json["meshes"][0]["primitives"][0]["material"] = 0;
  file.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}}};
  file.node({{"camera", 0}, {"name", "inside"}, {"translation", {0, 0, 3}}});
  file.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"name", "bulb"}}};
  file.node(
      {{"translation", {0, 1, 0}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  folder.write("parts/one.glb", file.glb());
  folder.write("parts/map.png", "x");
}

LoadedScene load_with(const TemporaryFolder& folder, const std::string& members) {
  return load_scene(folder.write("s.json", "{\"tessera\": 1, " + members + "}"));
}

TEST(Include, brings_all_that_a_gltf_file_has_moved_as_one) {
  const TemporaryFolder folder;
  write_part(folder);
  const LoadedScene loaded = load_with(
      folder,
      R"("include": [{"file": "parts/one.glb", "transform": [{"translate": [0, 0, 10]}]}])");
  const Scene& scene = loaded.scene;
  ASSERT_EQ(scene.shapes.size(), 1U);
  EXPECT_EQ(scene.shapes[0].to_world.m[11], 10);
  EXPECT_EQ(scene.materials.at(scene.shapes[0].material).name, "red");
  EXPECT_EQ(scene.images.size(), 1U);
  ASSERT_EQ(scene.cameras.size(), 1U);
  EXPECT_EQ(scene.cameras[0].name, "inside");
  EXPECT_EQ(scene.cameras[0].eye, (Vec3{0, 0, 13}));
  ASSERT_EQ(scene.lights.size(), 1U);
  EXPECT_EQ(std::get<PointLight>(scene.lights[0].shape).position, (Vec3{0, 1, 10}));
  ASSERT_EQ(loaded.files.size(), 3U);
  EXPECT_EQ(loaded.files[1].path, "parts/one.glb");
  EXPECT_EQ(loaded.files[2].path, "parts/map.png");
  EXPECT_THAT(loaded.warnings, testing::IsEmpty());
}

TEST(Include, the_scene_s_own_names_come_first) {
  const TemporaryFolder folder;
  write_part(folder);
  const LoadedScene loaded = load_with(folder, R"("include": ["parts/one.glb", "parts/one.glb"],
    "materials": {"blue": {"type": "diffuse"}, "red": {"type": "mirror"}},
    "cameras": [{"name": "mine", "eye": [0, 0, 5], "target": [0, 0, 0]}],
    "lights": [{"type": "point", "name": "bulb", "position": [7, 7, 7], "intensity": 1}],
    "shapes": [{"type": "sphere", "material": "red"}])");
  const Scene& scene = loaded.scene;
  EXPECT_EQ(scene.materials.size(), 2U);
  ASSERT_EQ(scene.shapes.size(), 1U);
  EXPECT_EQ(scene.shapes[0].material, 1U);
  EXPECT_EQ(scene.objects.at(0).shapes.at(0).material, 1U);
  ASSERT_EQ(scene.cameras.size(), 2U);
  EXPECT_EQ(scene.cameras[0].name, "mine");
  EXPECT_EQ(scene.cameras[1].name, "inside");
  ASSERT_EQ(scene.lights.size(), 1U);
  EXPECT_EQ(std::get<PointLight>(scene.lights[0].shape).position, (Vec3{7, 7, 7}));
}

TEST(Include, a_file_that_stands_several_times_is_in_memory_once) {
  const TemporaryFolder folder;
  write_part(folder);
  const LoadedScene loaded = load_with(folder, R"("include": ["parts/one.glb",
    {"file": "parts/one.glb", "transform": [{"translate": [5, 0, 0]}]},
    {"file": "parts/one.glb", "units": "blender"}])");
  const Scene& scene = loaded.scene;
  EXPECT_EQ(scene.shapes.size(), 1U) << "what is read in another way is another";
  ASSERT_EQ(scene.objects.size(), 1U);
  ASSERT_EQ(scene.objects[0].shapes.size(), 1U);
  ASSERT_EQ(scene.instances.size(), 2U);
  EXPECT_EQ(scene.instances[0].to_world.m[3], 0);
  EXPECT_EQ(scene.instances[1].to_world.m[3], 5);
  ASSERT_EQ(scene.lights.size(), 3U);
  EXPECT_EQ(std::get<PointLight>(scene.lights[1].shape).position, (Vec3{5, 1, 0}));
  EXPECT_EQ(scene.materials.size(), 2U);
}

/// Two nodes of one mesh, one of them without a name, and one of a mesh of its own.
void write_tree(const TemporaryFolder& folder) {
  GltfFile file;
  file.with_triangle();
  file.json["meshes"][0]["name"] = "leaf";
  file.json["nodes"][0]["name"] = "low leaf";
  file.node({{"mesh", 0}, {"translation", {0, 1, 0}}});
  file.json["meshes"].push_back(file.json["meshes"][0]);
  file.json["meshes"][1]["name"] = "trunk";
  file.node({{"mesh", 1}});
  folder.write("tree.glb", file.glb());
}

std::vector<std::string> names_in(const TemporaryFolder& folder, const std::string& include) {
  const Scene scene = load_with(folder, "\"include\": " + include).scene;
  const ObjectNames names = object_names(scene);
  return {names.names.begin(), names.names.end()};
}

TEST(Include, that_has_a_name_has_it_before_those_of_its_objects) {
  const TemporaryFolder folder;
  write_tree(folder);
  EXPECT_THAT(names_in(folder, R"(["tree.glb"])"), ElementsAre("trunk", "low leaf", "leaf"));
  EXPECT_THAT(names_in(folder, R"([{"file": "tree.glb", "name": "oak"}])"),
              ElementsAre("oak/trunk", "oak/low leaf", "oak/leaf"));
}

TEST(Include, what_stands_several_times_is_told_apart_by_the_includes_names) {
  const TemporaryFolder folder;
  write_tree(folder);
  // What is no instance in the file is one object then, called as the include.
  EXPECT_THAT(names_in(folder, R"([{"file": "tree.glb", "name": "oak"},
      {"file": "tree.glb", "name": "elm"}, "tree.glb", "tree.glb"])"),
              ElementsAre("oak/low leaf", "oak/leaf", "oak", "elm/low leaf", "elm/leaf", "elm",
                          "low leaf", "leaf", "tree.glb"));
  const LoadedScene twice = load_with(folder, R"("include": ["tree.glb", "tree.glb"])");
  EXPECT_EQ(twice.scene.instances.size(), 6U);
  EXPECT_EQ(twice.scene.instance_names.size(), 1U) << "what is included twice is named once";
}

TEST(Include, textures_of_several_files_are_told_apart) {
  const TemporaryFolder folder;
  write_part(folder);
  GltfFile other;
  other.with_triangle();
  other.json["images"] = {{{"uri", "data:,y"}}};
  other.json["textures"] = {{{"source", 0}}};
  other.json["materials"] = {{{"name", "green"}, {"emissiveTexture", {{"index", 0}}}}};
  other.json["meshes"][0]["primitives"][0]["material"] = 0;
  folder.write("other.glb", other.glb());
  const Scene scene = load_with(folder, R"("include": ["parts/one.glb", "other.glb"])").scene;
  const auto& red = std::get<Principled>(scene.materials.at(0).surface);
  const auto& green = std::get<Principled>(scene.materials.at(1).surface);
  ASSERT_EQ(scene.textures.size(), 2U);
  EXPECT_EQ(red.base_color.texture->texture, 0U);
  EXPECT_EQ(green.emission.texture->texture, 1U);
  EXPECT_EQ(scene.textures[1].image, 1U);
}

TEST(Include, what_nobody_brings_is_made_up) {
  const TemporaryFolder folder;
  GltfFile bare;
  bare.with_triangle();
  folder.write("bare.glb", bare.glb());
  const LoadedScene loaded = load_with(folder, R"("include": ["bare.glb"])");
  EXPECT_EQ(loaded.scene.cameras.size(), 1U);
  EXPECT_TRUE(loaded.scene.environment.has_value());
  EXPECT_THAT(loaded.warnings, Contains(HasSubstr("no camera")));
  EXPECT_THAT(loaded.warnings, Contains(HasSubstr("no light")));
  const LoadedScene lit =
      load_with(folder, R"("include": ["bare.glb"], "environment": {"radiance": 3})");
  EXPECT_EQ(lit.scene.environment->radiance, (Color{3, 3, 3}));
}

TEST(Include, takes_gltf_files_alone_and_none_that_lead_out) {
  const auto error_of_include = [](const std::string& name) {
    return error_of(R"({"tessera": 1, "include": [")" + name + "\"]}");
  };
  EXPECT_THAT(error_of_include("a.json").message(), HasSubstr("ends in .gltf or .glb"));
  EXPECT_EQ(error_of_include("../a.glb").place().key, "include[0]");
  EXPECT_EQ(error_of_include("a.glb").place().key, "include[0]");
}

}  // namespace
}  // namespace tessera::scene
