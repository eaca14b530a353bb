#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "tests/unit/scene/gltf_file.hpp"

namespace tessera::scene {
namespace {

using testing::Contains;
using testing::HasSubstr;

/// A triangle of the material `json`, with two textures of two images in the file.
LoadedScene load_with(const nlohmann::json& material) {
  GltfFile file;
  file.with_triangle();
  file.json["images"] = {
      {{"bufferView", file.view<char>({'o', 'n', 'e'})}, {"mimeType", "image/png"}},
      {{"uri", "data:image/png;base64," + base64("two")}}};
  file.json["samplers"] = {{{"magFilter", 9728}, {"wrapS", 33071}, {"wrapT", 33648}}};
  file.json["textures"] = {{{"source", 0}, {"sampler", 0}},
                           {{"extensions", {{"EXT_texture_webp", {{"source", 1}}}}}},
                           {{"sampler", 0}}};
  file.json["materials"] = nlohmann::json::array({material});
  file.json["meshes"][0]["primitives"][0]["material"] = 0;
  return file.load();
}

const Principled& surface_of(const LoadedScene& loaded) {
  return std::get<Principled>(loaded.scene.materials.at(0).surface);
}

TEST(GltfMaterial, a_primitive_without_one_is_white_metal_as_gltf_says) {
  GltfFile file;
  file.with_triangle();
  const LoadedScene loaded = file.load();
  ASSERT_EQ(loaded.scene.materials.size(), 1U);
  EXPECT_EQ(surface_of(loaded).base_color.factor, (Color{1, 1, 1}));
  EXPECT_EQ(surface_of(loaded).metallic.factor, 1);
  EXPECT_EQ(surface_of(loaded).roughness.factor, 1);
}

TEST(GltfMaterial, metallic_roughness_reads_its_channels) {
  const LoadedScene loaded =
      load_with({{"name", "clay"},
                 {"doubleSided", true},
                 {"alphaMode", "MASK"},
                 {"alphaCutoff", 0.25},
                 {"emissiveFactor", {1, 0.5, 0}},
                 {"normalTexture", {{"index", 0}, {"scale", 0.5}, {"texCoord", 1}}},
                 {"pbrMetallicRoughness",
                  {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}},
                   {"baseColorTexture", {{"index", 0}}},
                   {"metallicFactor", 0.6},
                   {"roughnessFactor", 0.7},
                   {"metallicRoughnessTexture", {{"index", 1}}}}},
                 {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 4}}}}}});
  const Material& material = loaded.scene.materials.at(0);
  const Principled& surface = surface_of(loaded);
  EXPECT_EQ(material.name, "clay");
  EXPECT_FALSE(material.back_culled);
  EXPECT_EQ(material.opacity.mode, Opacity::Mode::mask);
  EXPECT_EQ(material.opacity.cutoff, 0.25);
  EXPECT_EQ(material.opacity.alpha.factor, 0.4);
  EXPECT_EQ(material.opacity.alpha.channel, 3);
  EXPECT_EQ(surface.base_color.factor, (Color{0.1, 0.2, 0.3}));
  EXPECT_EQ(surface.metallic.factor, 0.6);
  EXPECT_EQ(surface.metallic.channel, 2);
  EXPECT_EQ(surface.roughness.factor, 0.7);
  EXPECT_EQ(surface.roughness.channel, 1);
  EXPECT_EQ(surface.emission.factor, (Color{4, 2, 0}));
  EXPECT_EQ(material.normal_map->scale, 0.5);
  EXPECT_EQ(material.normal_map->texture.uv_set, 1);
  EXPECT_FALSE(loaded.scene.environment.has_value()) << "it shines itself";

  const auto texture = [&](const TextureUse& use) { return loaded.scene.textures.at(use.texture); };
  const Texture color = texture(*surface.base_color.texture),
                normal = texture(material.normal_map->texture);
  EXPECT_EQ(color.color_space, ColorSpace::srgb);
  EXPECT_EQ(color.wrap_u, Wrap::clamp_to_edge);
  EXPECT_EQ(color.wrap_v, Wrap::mirrored_repeat);
  EXPECT_TRUE(color.nearest);
  EXPECT_EQ(normal.color_space, ColorSpace::linear);
  EXPECT_EQ(normal.image, color.image) << "one image, however it is used";
  EXPECT_EQ(texture(*surface.metallic.texture).color_space, ColorSpace::linear);
  ASSERT_EQ(loaded.scene.images.size(), 2U);
}

TEST(GltfMaterial, images_stay_encoded_where_they_lie) {
  const LoadedScene loaded = load_with(
      {{"pbrMetallicRoughness",
        {{"baseColorTexture", {{"index", 0}}}, {"metallicRoughnessTexture", {{"index", 1}}}}}});
  const auto& in_file = std::get<FileRange>(loaded.scene.images.at(0).encoded);
  EXPECT_EQ(in_file.size, 3U);
  EXPECT_GT(in_file.offset, 100U);
  const auto& held = *std::get<1>(loaded.scene.images.at(1).encoded);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(held.data()), held.size()), "two");
}

TEST(GltfMaterial, texture_transforms_are_those_of_the_specification_s_example) {
  const LoadedScene loaded = load_with({{"emissiveTexture",
                                         {{"index", 0},
                                          {"extensions",
                                           {{"KHR_texture_transform",
                                             {{"offset", {0, 1}},
                                              {"rotation", std::numbers::pi / 2},
                                              {"scale", {0.5, 0.5}},
                                              {"texCoord", 1}}}}}}}});
  const TextureUse use = *surface_of(loaded).emission.texture;
  EXPECT_EQ(use.uv_set, 1);
  // The lower left quadrant, turned clockwise: the upper left corner sees that quadrant's lower
  // left, the upper right corner its upper left.
  const auto at = [&](double u, double v) {
    const auto& m = use.to_uv;
    return Vec2{m[0] * u + m[1] * v + m[2], m[3] * u + m[4] * v + m[5]};
  };
  EXPECT_NEAR(at(0, 0)[0], 0, 1e-12);
  EXPECT_NEAR(at(0, 0)[1], 1, 1e-12);
  EXPECT_NEAR(at(1, 0)[0], 0, 1e-12);
  EXPECT_NEAR(at(1, 0)[1], 0.5, 1e-12);
  EXPECT_NEAR(at(0, 1)[0], 0.5, 1e-12);
}

TEST(GltfMaterial, extensions_fill_the_principled_surface) {
  const nlohmann::json texture{{"index", 0}};
  const LoadedScene loaded =
      load_with({{"extensions",
                  {{"KHR_materials_ior", {{"ior", 1.33}}},
                   {"KHR_materials_transmission",
                    {{"transmissionFactor", 0.9}, {"transmissionTexture", texture}}},
                   {"KHR_materials_volume",
                    {{"thicknessFactor", 1},
                     {"attenuationDistance", 2},
                     {"attenuationColor", {0.1, 0.2, 0.3}}}},
                   {"KHR_materials_specular",
                    {{"specularFactor", 0.5},
                     {"specularTexture", texture},
                     {"specularColorFactor", {1, 2, 3}}}},
                   {"KHR_materials_clearcoat",
                    {{"clearcoatFactor", 0.8},
                     {"clearcoatRoughnessFactor", 0.1},
                     {"clearcoatRoughnessTexture", texture},
                     {"clearcoatNormalTexture", {{"index", 0}, {"scale", 2}}}}},
                   {"KHR_materials_anisotropy",
                    {{"anisotropyStrength", 0.6},
                     {"anisotropyRotation", 1.5},
                     {"anisotropyTexture", texture}}}}}});
  const Principled& surface = surface_of(loaded);
  EXPECT_EQ(surface.ior, 1.33);
  EXPECT_EQ(surface.transmission.factor, 0.9);
  EXPECT_EQ(surface.transmission.channel, 0);
  EXPECT_FALSE(surface.thin_walled);
  EXPECT_FALSE(loaded.scene.materials[0].back_culled) << "light leaves at the back";
  EXPECT_EQ(surface.attenuation_distance, 2);
  EXPECT_EQ(surface.attenuation_color, (Color{0.1, 0.2, 0.3}));
  EXPECT_EQ(surface.specular.factor, 0.5);
  EXPECT_EQ(surface.specular.channel, 3);
  EXPECT_EQ(surface.specular_color.factor, (Color{1, 2, 3}));
  EXPECT_EQ(surface.clearcoat.factor, 0.8);
  EXPECT_EQ(surface.clearcoat_roughness.factor, 0.1);
  EXPECT_EQ(surface.clearcoat_roughness.channel, 1);
  EXPECT_EQ(surface.clearcoat_normal->scale, 2);
  EXPECT_EQ(surface.anisotropy.factor, 0.6);
  EXPECT_EQ(surface.anisotropy_rotation, 1.5);
  EXPECT_TRUE(surface.anisotropy_direction.has_value());
}

TEST(GltfMaterial, an_empty_extension_counts) {
  EXPECT_TRUE(
      surface_of(load_with({{"extensions", {{"KHR_materials_unlit", nlohmann::json::object()}}}}))
          .unlit);
  EXPECT_TRUE(
      surface_of(load_with({{"extensions", {{"KHR_materials_volume", nlohmann::json::object()}}}}))
          .thin_walled);
}

TEST(GltfMaterial, textures_that_cannot_be_read_are_left_out_with_a_warning) {
  const LoadedScene no_image = load_with({{"emissiveTexture", {{"index", 2}}}});
  EXPECT_FALSE(surface_of(no_image).emission.texture.has_value());
  EXPECT_THAT(no_image.warnings, Contains(HasSubstr("/textures/2 has no image")));
  const LoadedScene third_set = load_with({{"emissiveTexture", {{"index", 0}, {"texCoord", 2}}}});
  EXPECT_FALSE(surface_of(third_set).emission.texture.has_value());
  EXPECT_THAT(third_set.warnings, Contains(HasSubstr("set 2")));
}

}  // namespace
}  // namespace tessera::scene
