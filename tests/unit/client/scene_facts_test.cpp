#include "client/scene_facts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "tests/support/temporary_folder.hpp"

namespace tessera::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

scene::Mesh mesh_of(std::size_t triangles) {
  scene::Mesh out;
  out.positions.resize(3);
  out.triangles.resize(triangles);
  return out;
}

scene::LoadedScene scene_of(const TemporaryFolder& folder) {
  scene::LoadedScene out;
  out.files.push_back({"s.json", folder.write("s.json", "12345")});
  scene::Scene& scene = out.scene;
  scene.render.width = 64;
  scene.render.height = 32;
  scene.cameras = {{.name = "front"}, {.name = "side"}};
  scene.materials = {
      {.name = "lamp", .surface = scene::Emitter{}},
      {.name = "glow", .surface = scene::Principled{.emission = {.factor = {1, 0, 0}}}},
      {.name = "wall", .surface = scene::Diffuse{}}};
  scene.shapes = {{.name = "q", .geometry = scene::Quad{}, .to_world = {}},
                  {.name = "b", .geometry = scene::Box{}, .to_world = {}},
                  {.name = "s", .geometry = scene::Sphere{}, .to_world = {}}};
  scene.objects = {
      {.name = "o", .shapes = {{.name = "m", .geometry = mesh_of(5), .to_world = {}}}}};
  scene.instances = {
      {.object = 0, .to_world = {}}, {.object = 0, .to_world = {}}, {.object = 0, .to_world = {}}};
  scene.lights = {{.name = "sun", .shape = scene::DirectionalLight{}}};
  out.warnings = {"s.json: nothing moves"};
  return out;
}

TEST(SceneFacts, count_what_is_kept_and_what_rays_meet) {
  const TemporaryFolder folder;
  const SceneFacts facts = facts_of(scene_of(folder), 3000);
  EXPECT_EQ(facts.triangles, 2U + 12 + 5);
  EXPECT_EQ(facts.triangles_placed, 2U + 12 + 15);
  EXPECT_EQ(facts.spheres, 1U);
  EXPECT_EQ(facts.shapes, 4U);
  EXPECT_EQ(facts.instances, 3U);
  EXPECT_EQ(facts.materials, 3U);
  EXPECT_EQ(facts.emitting_materials, 2U);
  EXPECT_EQ(facts.lights, 1U);
  EXPECT_FALSE(facts.environment);
  EXPECT_THAT(facts.cameras, ElementsAre("front", "side"));
  EXPECT_EQ(facts.file_bytes, 5U);
  // 3 positions of 12 bytes, 5 faces of 14; quads of 4 positions, indices and a material; a sphere.
  EXPECT_EQ(facts.geometry_bytes, 36U + 70 + 7 * 66 + 18);
  EXPECT_EQ(facts.texture_bytes, 4000U) << "with mip levels";
  EXPECT_GT(facts.memory_bytes, facts.texture_bytes + facts.geometry_bytes);
}

TEST(SceneFacts, count_coordinates_where_a_texture_or_the_scenes_AOVs_look_at_them) {
  const TemporaryFolder folder;
  const auto bytes = [&](const std::optional<scene::TextureUse>& use,
                         const std::vector<std::string>& aovs, bool second) {
    scene::LoadedScene loaded = scene_of(folder);
    scene::Scene& scene = loaded.scene;
    scene.render.aovs = aovs;
    std::get<scene::Principled>(scene.materials[1].surface).base_color.texture = use;
    scene::Shape& shape = scene.objects[0].shapes[0];
    shape.material = 1;
    std::get<scene::Mesh>(shape.geometry).uvs.resize(3);
    if (second) std::get<scene::Mesh>(shape.geometry).uvs1.resize(3);
    return facts_of(loaded, 0).geometry_bytes;
  };
  const std::uint64_t none = bytes({}, {"N"}, true);
  constexpr std::uint64_t of_mesh = 3 * 8, of_quads = 7 * 4 * 8;
  const scene::TextureUse by_first, by_second{.uv_set = 1};
  EXPECT_EQ(bytes(by_first, {}, true), none + of_mesh);
  EXPECT_EQ(bytes(by_second, {}, true), none + of_mesh);
  EXPECT_EQ(bytes(by_second, {}, false), none + of_mesh) << "the first stands in for it";
  EXPECT_EQ(bytes({}, {"N", "UV"}, true), none + of_mesh + of_quads);
  EXPECT_EQ(bytes(by_second, {"UV"}, true), none + 2 * of_mesh + of_quads);
}

TEST(SceneFacts, are_said_in_words_and_in_json) {
  const TemporaryFolder folder;
  const SceneFacts facts = facts_of(scene_of(folder), 3000);
  const std::string text = text_of(facts);
  EXPECT_THAT(text, HasSubstr("triangles   19, 29 with instances\n"));
  EXPECT_THAT(text, HasSubstr("cameras     front, side\n"));
  EXPECT_THAT(text, HasSubstr("note        s.json: nothing moves\n"));
  const Json json = to_json(facts);
  EXPECT_EQ(json["triangles_placed"], 29);
  EXPECT_EQ(json["cameras"][1], "side");
  EXPECT_EQ(json["warnings"].size(), 1U);
}

TEST(SceneFacts, say_what_the_film_is_and_whether_shadows_are_caught) {
  const TemporaryFolder folder;
  scene::LoadedScene loaded = scene_of(folder);
  EXPECT_THAT(text_of(facts_of(loaded, 0)), HasSubstr("film        64x32\n"));
  loaded.scene.film_transparent = true;
  EXPECT_THAT(text_of(facts_of(loaded, 0)), HasSubstr("film        64x32, transparent\n"));
  loaded.scene.shapes[1].visibility.shadow_catcher = true;
  const SceneFacts facts = facts_of(loaded, 0);
  EXPECT_THAT(text_of(facts), HasSubstr("film        64x32, transparent, catches shadows\n"));
  EXPECT_EQ(to_json(facts)["shadow_catchers"], true);
  EXPECT_EQ(to_json(facts)["film_transparent"], true);
}

}  // namespace
}  // namespace tessera::client
