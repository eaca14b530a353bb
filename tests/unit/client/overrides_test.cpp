#include "client/overrides.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "client/prepare.hpp"
#include "client/wedge_jobs.hpp"
#include "tests/unit/client/support.hpp"

namespace tessera::client {
namespace {

using testing::HasSubstr;

constexpr std::string_view lit_scene =
    R"({"tessera": 1, "camera": {"eye": [0, 0, 5], "target": [0, 0, 0]}, "environment": {"radiance": 3, "rotation": 4}})";
/// A triangle, a lamp of 683 candela, and a material with a variant.
constexpr std::string_view model = R"({
  "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
  "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_variants"],
  "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 683}]},
    "KHR_materials_variants": {"variants": [{"name": "oak"}, {"name": "beech"}]}},
  "nodes": [{"mesh": 0}, {"extensions": {"KHR_lights_punctual": {"light": 0}}}],
  "materials": [{"name": "plain"}, {"name": "light"}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0,
    "extensions": {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [1]}]}}}]}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
  "bufferViews": [{"buffer": 0, "byteLength": 36}],
  "buffers": [{"byteLength": 36, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";

constexpr std::string_view one_texel =
    "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x40\x40\x40\x81";

class Overrides : public testing::Test {
 protected:
  [[nodiscard]] scene::LoadedScene load(std::string_view text, const SceneOverrides& overrides,
                                        const std::string& name = "scene.json") const {
    const NamedScene named = named_scene(folder_.write(name, text), overrides);
    scene::LoadedScene out = survey_named_scene(named);
    if (!out.problems.empty()) throw scene::as_one(out.problems);
    return out;
  }
  [[nodiscard]] Error refusal(std::string_view text, const SceneOverrides& overrides,
                              const std::string& name = "scene.json") const {
    return error_of([&] { (void)load(text, overrides, name); });
  }
  TemporaryFolder folder_;
};

double lamp_of(const scene::Scene& scene) {
  return std::get<scene::PointLight>(scene.lights.at(0).shape).intensity[0];
}

TEST_F(Overrides, an_environment_takes_the_place_of_the_scene_s) {
  const auto colour = load(lit_scene, {.environment = "1,0.5,2", .environment_strength = 7});
  EXPECT_EQ(colour.scene.environment->radiance, (scene::Color{1, 0.5, 2}));
  EXPECT_EQ(colour.scene.environment->strength, 7);
  EXPECT_EQ(colour.scene.environment->rotation_degrees, 0) << "the scene's environment is gone";
  const auto turned = load(lit_scene, {.environment_rotation = 90});
  EXPECT_EQ(turned.scene.environment->radiance, (scene::Color{3, 3, 3}));
  EXPECT_EQ(turned.scene.environment->rotation_degrees, 90);
  const auto studio = load(lit_scene, {.environment = "studio", .environment_rotation = 30});
  EXPECT_TRUE(studio.scene.environment->image.has_value());
  EXPECT_DOUBLE_EQ(studio.scene.environment->rotation_degrees, 30) << "the camera is in front";
}

TEST_F(Overrides, an_environment_s_picture_may_lie_anywhere_and_travels_with_the_scene) {
  const TemporaryFolder elsewhere;
  const auto picture = elsewhere.write("sky.hdr", one_texel);
  JobOptions options;
  options.scene = folder_.write("scene.json", lit_scene);
  const Digest before = prepare(options).spec.bundle;
  options.overrides.environment = picture.string();
  const PreparedJob job = prepare(options);
  EXPECT_NE(job.spec.bundle, before);
  EXPECT_EQ(job.assets.bundle.scene, "scene.json");
  ASSERT_EQ(job.assets.bundle.files.size(), 2U);
  EXPECT_EQ(job.assets.bundle.files.at("tessera-environment/picture").digest, digest_of(one_texel));
  std::string text;
  std::getline(std::ifstream(job.assets.files.at(0).file), text, '\0');
  EXPECT_THAT(text, HasSubstr("tessera-environment/picture")) << "the edited scene can be read";
  EXPECT_EQ(prepare(options).spec.bundle, job.spec.bundle) << "what is the same has one name";
}

TEST_F(Overrides, a_gltf_file_is_included_by_a_document_that_shows_the_same) {
  const auto plain = load(model, {}, "model.gltf");
  const auto lit = load(model, {.environment = "2"}, "model.gltf");
  EXPECT_EQ(lit.scene.render.width, plain.scene.render.width);
  EXPECT_EQ(lit.scene.render.height, plain.scene.render.height);
  EXPECT_EQ(lit.scene.cameras.at(0).eye, plain.scene.cameras.at(0).eye);
  EXPECT_EQ(lit.scene.shapes.size(), 1U);
  EXPECT_FALSE(plain.scene.environment.has_value());
  EXPECT_EQ(lit.scene.environment->radiance, (scene::Color{2, 2, 2}));
  ASSERT_EQ(lit.files.size(), 2U);
  EXPECT_EQ(lit.files[0].path, "model.gltf.overridden.json");
  EXPECT_EQ(lit.files[1].path, "model.gltf");
}

TEST_F(Overrides, a_variant_and_units_are_passed_to_gltf_files) {
  const auto shown = [&](const SceneOverrides& overrides) {
    const auto loaded = load(model, overrides, "model.gltf");
    return loaded.scene.materials.at(loaded.scene.shapes.at(0).material).name;
  };
  EXPECT_EQ(shown({}), "plain");
  EXPECT_EQ(shown({.variant = "beech"}), "light");
  EXPECT_EQ(shown({.variant = "oak"}), "plain") << "the primitive has no mapping for it";
  EXPECT_EQ(lamp_of(load(model, {}, "model.gltf").scene), 683);
  EXPECT_DOUBLE_EQ(lamp_of(load(model, {.units = "blender"}, "model.gltf").scene), 1);
  folder_.write("model.gltf", model);
  EXPECT_DOUBLE_EQ(
      lamp_of(load(R"({"tessera": 1, "include": ["model.gltf"]})", {.units = "blender"}).scene), 1);
  EXPECT_THAT(load(model, {}, "model.gltf").variants, testing::ElementsAre("oak", "beech"));
}

TEST_F(Overrides, what_cannot_be_overridden_is_said_with_its_flag) {
  constexpr std::string_view dark =
      R"({"tessera": 1, "camera": {"eye": [0, 0, 5], "target": [0, 0, 0]}})";
  EXPECT_EQ(refusal(dark, {.environment_strength = 2}).place().key, "--env-strength");
  EXPECT_EQ(refusal(dark, {.environment = "no/where.hdr"}).place().key, "--env");
  EXPECT_EQ(refusal(dark, {.variant = "oak"}).place().key, "--variant");
  EXPECT_EQ(refusal(dark, {.units = "blender"}).place().key, "--units");
  EXPECT_THAT(refusal(model, {.variant = "beach"}, "model.gltf").message(), HasSubstr("beech"));
  const Error units = refusal(model, {.units = "blendr"}, "model.gltf");
  EXPECT_THAT(units.message(), HasSubstr("blender"));
  EXPECT_EQ(units.place().line, 0) << "of no file";
  EXPECT_THAT(refusal(dark, {.environment = "-1,0,0"}).message(), HasSubstr("-1"));
}

TEST_F(Overrides, a_wedge_varies_an_overridden_scene) {
  JobOptions options;
  options.scene = folder_.write("model.gltf", model);
  options.overrides.environment = "2";
  std::vector<Vary> axes{vary_from("environment.rotation=0,90"), vary_from("samples=1,2")};
  options.overrides.environment_rotation = 0;
  const PreparedWedge wedge = prepare_wedge(plan_wedge(options, std::move(axes)));
  ASSERT_EQ(wedge.scenes.size(), 2U);
  EXPECT_NE(wedge.scenes[0].digest, wedge.scenes[1].digest);
  EXPECT_EQ(wedge.scenes[1].bundle.files.size(), 2U);
  EXPECT_EQ(wedge.jobs.size(), 4U);
}

}  // namespace
}  // namespace tessera::client
