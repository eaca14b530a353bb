#include <gtest/gtest.h>

#include <type_traits>

#include "common/base/error.hpp"
#include "common/scene/parts.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/scene/support.hpp"

namespace tessera::scene {
namespace {

/// A scene's `textures`, and one input that uses them.
class Textures : public testing::Test {
 protected:
  Textures() : files_(folder()) {
    folder_.write("wood.png", "x");
    folder_.write("rough.png", "x");
  }
  const std::filesystem::path& folder() { return folder_.path(); }

  ColorInput color(const std::string& textures, const std::string& input) {
    return read(textures, input,
                [&](Fields& in) { return color_input_or(in, "input", 1, {}, reading_); });
  }
  ScalarInput scalar(const std::string& textures, const std::string& input) {
    return read(textures, input,
                [&](Fields& in) { return scalar_input_or(in, "input", 0, 1, {}, reading_); });
  }
  std::string said(const std::string& textures, const std::string& input) {
    try {
      (void)color(textures, input);
    } catch (const Error& error) {
      return error.what();
    }
    return reading_.problems.empty() ? "nothing" : reading_.problems.back().what();
  }

  template <class Use>
  std::invoke_result_t<Use, Fields&> read(const std::string& textures, const std::string& input,
                                          Use use) {
    const Document named(textures, "textures.json");
    read_textures(Value(named, 0), reading_);
    const Document document("{\"input\": " + input + "}", "input.json");
    Fields in{Value(document, 0)};
    return use(in);
  }

  TemporaryFolder folder_;
  FolderFiles files_;
  Reading reading_{files_, Moment{}, Keep::meshes};
};

TEST_F(Textures, a_name_a_file_or_a_plain_value_may_feed_an_input) {
  EXPECT_FALSE(color("{}", "[0.1, 0.2, 0.3]").texture.has_value());
  EXPECT_EQ(scalar("{}", "0.25").factor, 0.25);
  const ColorInput named = color(R"({"oak": {"file": "wood.png"}})", R"("oak")");
  ASSERT_TRUE(named.texture.has_value());
  EXPECT_EQ(named.factor, (Color{1, 1, 1}));
  EXPECT_EQ(reading_.images.size(), 1U);
  EXPECT_EQ(reading_.used().at(0).path, "wood.png");
  const ColorInput inlined =
      color("{}", R"({"file": "./wood.png", "factor": 0.5, "uv_set": 1, "filter": "nearest"})");
  EXPECT_EQ(inlined.factor, (Color{0.5, 0.5, 0.5}));
  EXPECT_EQ(inlined.texture->uv_set, 1);
  EXPECT_TRUE(reading_.textures.at(inlined.texture->texture).nearest);
  EXPECT_EQ(reading_.images.size(), 1U) << "one file, one picture";
}

TEST_F(Textures, the_input_says_what_texels_mean_unless_the_texture_does) {
  const std::string textures =
      R"({"a": {"file": "wood.png"}, "b": {"file": "rough.png", "color_space": "srgb"}})";
  const auto space = [&](const auto& input) {
    return reading_.textures.at(input.texture->texture).color_space;
  };
  EXPECT_EQ(space(color(textures, R"("a")")), ColorSpace::srgb);
  EXPECT_EQ(space(scalar(textures, R"("a")")), ColorSpace::linear);
  EXPECT_EQ(space(scalar(textures, R"("b")")), ColorSpace::srgb);
  EXPECT_EQ(scalar(textures, R"({"texture": "a", "channel": "b"})").channel, 2);
}

TEST_F(Textures, feed_the_inputs_of_materials) {
  const Scene scene = parse_scene(
      R"({"tessera": 1, "camera": {"eye": [0, 0, 5], "target": [0, 0, 0]},
          "textures": {"oak": {"file": "wood.png"}},
          "materials": {
            "floor": {"type": "principled", "base_color": "oak",
                      "roughness": {"file": "rough.png", "channel": "g", "factor": 0.5}},
            "steel": {"type": "conductor", "name": "iron"},
            "worn": {"type": "mix", "materials": ["floor", "steel"], "amount": "oak",
                     "opacity": {"texture": "oak", "channel": "a"}}}})",
      "floor.json", files_);
  ASSERT_EQ(scene.materials.size(), 3U);
  const auto& floor = std::get<Principled>(scene.materials[0].surface);
  ASSERT_TRUE(floor.base_color.texture && floor.roughness.texture);
  EXPECT_EQ(scene.textures.at(floor.base_color.texture->texture).color_space, ColorSpace::srgb);
  EXPECT_EQ(scene.textures.at(floor.roughness.texture->texture).color_space, ColorSpace::linear);
  EXPECT_EQ(floor.roughness.channel, 1);
  EXPECT_EQ(floor.roughness.factor, 0.5);
  EXPECT_TRUE(std::get<Mix>(scene.materials[2].surface).amount.texture.has_value());
  EXPECT_EQ(scene.materials[2].opacity.alpha.channel, 3);
  EXPECT_EQ(scene.images.size(), 2U);
}

TEST_F(Textures, bend_normals_and_cut_holes) {
  const std::string scene = R"({
    "tessera": 1, "camera": {"eye": [0, 0, 5], "target": [0, 0, 0]},
    "textures": {"wood": {"file": "wood.png"}},
    "materials": {
      "a": {"type": "diffuse", "normal_map": "wood", "opacity": {"texture": "wood", "channel": "a"}, "alpha_cutoff": 0.4},
      "b": {"type": "conductor", "name": "gold",
            "bump_map": {"texture": "wood", "height": 0.02, "scale": 3}},
      "c": {"type": "principled", "clearcoat": 1,
            "clearcoat_normal_map": {"file": "rough.png", "strength": 0.5, "uv_set": 1}}}})";
  const Scene out = parse_scene(scene, "scene.json", files_);
  const Material &a = out.materials.at(0), &b = out.materials.at(1), &c = out.materials.at(2);
  ASSERT_TRUE(a.normal_map && b.bump_map);
  EXPECT_EQ(out.textures.at(a.normal_map->texture.texture).color_space, ColorSpace::linear);
  EXPECT_EQ(a.normal_map->scale, 1);
  EXPECT_EQ(a.opacity.mode, Opacity::Mode::mask);
  EXPECT_EQ(a.opacity.cutoff, 0.4);
  EXPECT_EQ(a.opacity.alpha.channel, 3);
  EXPECT_EQ(b.bump_map->height, 0.02);
  EXPECT_EQ(b.bump_map->texture.to_uv[0], 3);
  EXPECT_EQ(b.opacity.mode, Opacity::Mode::opaque);
  const auto& coat = std::get<Principled>(c.surface).clearcoat_normal;
  ASSERT_TRUE(coat.has_value());
  EXPECT_EQ(coat->scale, 0.5);
  EXPECT_EQ(coat->texture.uv_set, 1);
  EXPECT_EQ(error_of(scene_with(R"("materials": {"m": {"type": "diffuse", "alpha_cutoff": 0.5}},)"))
                .place()
                .key,
            "materials.m.alpha_cutoff");
}

TEST_F(Textures, scale_then_rotation_then_offset) {
  const auto use = color("{}", R"({"file": "wood.png", "scale": [2, 3], "rotation": 90,
                                   "offset": [0.25, 0.5], "wrap": ["repeat", "clamp_to_edge"]})");
  const std::array<double, 6>& m = use.texture->to_uv;
  // u grows to the right and is turned upwards, against v.
  EXPECT_NEAR(m[0], 0, 1e-12);
  EXPECT_NEAR(m[3], -2, 1e-12);
  EXPECT_NEAR(m[1], 3, 1e-12);
  EXPECT_NEAR(m[4], 0, 1e-12);
  EXPECT_EQ(m[2], 0.25);
  EXPECT_EQ(m[5], 0.5);
  const Texture& texture = reading_.textures.at(use.texture->texture);
  EXPECT_EQ(texture.wrap_u, Wrap::repeat);
  EXPECT_EQ(texture.wrap_v, Wrap::clamp_to_edge);
}

TEST_F(Textures, what_is_wrong_is_said_with_the_nearest_name) {
  const std::string textures = R"({"oak": {"file": "wood.png"}})";
  EXPECT_NE(said(textures, R"("oka")").find("oak"), std::string::npos);
  EXPECT_NE(said(textures, R"({"file": "wod.png"})").find("wod.png"), std::string::npos);
  EXPECT_NE(said(textures, R"({"texture": "oak", "wrap": "repeat"})").find("textures"),
            std::string::npos);
  EXPECT_NE(said("{}", R"({"file": "wood.png", "wrap": "repaet"})").find("repeat"),
            std::string::npos);
  EXPECT_NE(said("{}", R"({"file": "wood.png", "ofset": [0, 0]})").find("offset"),
            std::string::npos);
  EXPECT_NE(said("{}", R"({"file": "../wood.png"})").find("outside"), std::string::npos);
}

}  // namespace
}  // namespace tessera::scene
