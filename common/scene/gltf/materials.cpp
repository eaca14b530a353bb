#include "common/scene/gltf/materials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/limits.hpp"
#include "common/base/names.hpp"
#include "common/scene/fields.hpp"

namespace tessera::scene::gltf {

namespace {

constexpr std::size_t name_bytes = 120;

Wrap wrap_of(int mode) {
  if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return Wrap::clamp_to_edge;
  if (mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return Wrap::mirrored_repeat;
  return Wrap::repeat;
}

Vec2 pair_or(const tinygltf::Value& object, const std::string& key, const Vec2& fallback) {
  const tinygltf::Value* value = member(object, key);
  if (value == nullptr || value->ArrayLen() != 2) return fallback;
  return {value->Get(0).GetNumberAsDouble(), value->Get(1).GetNumberAsDouble()};
}

/// KHR_texture_transform: offset after rotation, counter-clockwise as v runs down, after scale.
std::array<double, 6> transform_of(const tinygltf::Value& from) {
  const Vec2 offset = pair_or(from, "offset", {0, 0}), scale = pair_or(from, "scale", {1, 1});
  const double rotation = number_or(from, "rotation", 0);
  const double s = std::sin(rotation), c = std::cos(rotation);
  return {c * scale[0], s * scale[1], offset[0], -s * scale[0], c * scale[1], offset[1]};
}

Opacity::Mode mode_of(const std::string& mode) {
  if (mode == "MASK") return Opacity::Mode::mask;
  return mode == "BLEND" ? Opacity::Mode::blend : Opacity::Mode::opaque;
}

}  // namespace

std::uint32_t Materials::use(int material) {
  const auto [found, fresh] =
      known_.try_emplace(material, static_cast<std::uint32_t>(materials_.size()));
  if (fresh) {
    if (materials_.size() == limits::materials_max)
      asset_.fail("/materials", fmt::format("more than {} are used", limits::materials_max));
    materials_.push_back(read(material));
  }
  return found->second;
}

void Materials::move_into(Scene& scene) {
  scene.materials = std::move(materials_);
  scene.textures = std::move(textures_);
  scene.images = std::move(images_);
}

std::string Materials::name_for(const tinygltf::Material& material, int index) {
  std::string name = excerpt(material.name, name_bytes);
  if (name.empty()) name = fmt::format("material {}", index);
  while (!names_.insert(name).second) name = fmt::format("{} ({})", name, index);
  return name;
}

Material Materials::read(int index) {
  static const tinygltf::Material without = [] {
    tinygltf::Material out;
    out.emissiveFactor = {0, 0, 0};
    return out;
  }();
  const tinygltf::Material& from =
      index < 0 ? without : asset_.model.materials[static_cast<std::size_t>(index)];
  const std::string place = fmt::format("/materials/{}", index);
  Material out;
  out.name = index < 0 ? "default material" : name_for(from, index);
  Principled surface;

  const tinygltf::PbrMetallicRoughness& pbr = from.pbrMetallicRoughness;
  const auto& base = pbr.baseColorFactor;
  surface.base_color.factor = {base[0], base[1], base[2]};
  surface.base_color.texture =
      use_texture({.texture = pbr.baseColorTexture.index,
                   .uv_set = pbr.baseColorTexture.texCoord,
                   .extensions = &pbr.baseColorTexture.extensions,
                   .place = place + "/pbrMetallicRoughness/baseColorTexture"},
                  ColorSpace::srgb);
  const auto rough =
      use_texture({.texture = pbr.metallicRoughnessTexture.index,
                   .uv_set = pbr.metallicRoughnessTexture.texCoord,
                   .extensions = &pbr.metallicRoughnessTexture.extensions,
                   .place = place + "/pbrMetallicRoughness/metallicRoughnessTexture"},
                  ColorSpace::linear);
  surface.metallic = {.factor = pbr.metallicFactor, .texture = rough, .channel = 2};
  surface.roughness = {.factor = pbr.roughnessFactor, .texture = rough, .channel = 1};
  surface.emission.factor = {from.emissiveFactor[0], from.emissiveFactor[1],
                             from.emissiveFactor[2]};
  surface.emission.texture = use_texture({.texture = from.emissiveTexture.index,
                                          .uv_set = from.emissiveTexture.texCoord,
                                          .extensions = &from.emissiveTexture.extensions,
                                          .place = place + "/emissiveTexture"},
                                         ColorSpace::srgb);
  read_extensions(from, place, surface);

  out.opacity.mode = mode_of(from.alphaMode);
  out.opacity.cutoff = from.alphaCutoff;
  out.opacity.alpha = {.factor = base[3], .texture = surface.base_color.texture, .channel = 3};
  if (auto normal = use_texture({.texture = from.normalTexture.index,
                                 .uv_set = from.normalTexture.texCoord,
                                 .extensions = &from.normalTexture.extensions,
                                 .place = place + "/normalTexture"},
                                ColorSpace::linear))
    out.normal_map = NormalMap{.texture = *normal, .scale = from.normalTexture.scale};
  // What lets light through has two sides.
  out.back_culled = !from.doubleSided && index >= 0 && surface.transmission.factor == 0;
  out.surface = surface;
  return out;
}

void Materials::read_extensions(const tinygltf::Material& from, const std::string& place,
                                Principled& out) {
  const tinygltf::ExtensionMap& all = from.extensions;
  out.unlit = extension(all, "KHR_materials_unlit") != nullptr;
  if (const auto* ior = extension(all, "KHR_materials_ior")) {
    // 0 stands for an index without end.
    const double value = number_or(*ior, "ior", 1.5);
    out.ior = value == 0 ? 1000.0 : std::max(value, 1.0);
  }
  if (const auto* strength = extension(all, "KHR_materials_emissive_strength"))
    for (double& channel : out.emission.factor)
      channel *= number_or(*strength, "emissiveStrength", 1);
  if (const auto* transmission = extension(all, "KHR_materials_transmission"))
    out.transmission = {
        .factor = number_or(*transmission, "transmissionFactor", 0),
        .texture = member_texture(*transmission, "transmissionTexture", ColorSpace::linear, place),
        .channel = 0};
  read_volume(all, out);
  if (const auto* specular = extension(all, "KHR_materials_specular"))
    read_specular(*specular, place, out);
  if (const auto* clearcoat = extension(all, "KHR_materials_clearcoat"))
    read_clearcoat(*clearcoat, place, out);
  if (const auto* anisotropy = extension(all, "KHR_materials_anisotropy"))
    read_anisotropy(*anisotropy, place, out);
}

/// The thickness itself is for renderers that do not follow rays through a mesh.
void Materials::read_volume(const tinygltf::ExtensionMap& extensions, Principled& out) {
  const tinygltf::Value* volume = extension(extensions, "KHR_materials_volume");
  if (volume == nullptr) return;
  out.thin_walled = !(number_or(*volume, "thicknessFactor", 0) > 0);
  out.attenuation_color = color_or(*volume, "attenuationColor", {1, 1, 1});
  const double distance = number_or(*volume, "attenuationDistance", 0);
  out.attenuation_distance = out.thin_walled || distance > length_most ? 0 : distance;
}

void Materials::read_specular(const tinygltf::Value& from, const std::string& place,
                              Principled& out) {
  out.specular = {.factor = number_or(from, "specularFactor", 1),
                  .texture = member_texture(from, "specularTexture", ColorSpace::linear, place),
                  .channel = 3};
  out.specular_color = {
      .factor = color_or(from, "specularColorFactor", {1, 1, 1}),
      .texture = member_texture(from, "specularColorTexture", ColorSpace::srgb, place)};
}

void Materials::read_clearcoat(const tinygltf::Value& from, const std::string& place,
                               Principled& out) {
  out.clearcoat = {.factor = number_or(from, "clearcoatFactor", 0),
                   .texture = member_texture(from, "clearcoatTexture", ColorSpace::linear, place),
                   .channel = 0};
  out.clearcoat_roughness = {
      .factor = number_or(from, "clearcoatRoughnessFactor", 0),
      .texture = member_texture(from, "clearcoatRoughnessTexture", ColorSpace::linear, place),
      .channel = 1};
  if (const auto normal = member_texture(from, "clearcoatNormalTexture", ColorSpace::linear, place))
    out.clearcoat_normal =
        NormalMap{.texture = *normal,
                  .scale = number_or(*member(from, "clearcoatNormalTexture"), "scale", 1)};
}

void Materials::read_anisotropy(const tinygltf::Value& from, const std::string& place,
                                Principled& out) {
  out.anisotropy.factor = number_or(from, "anisotropyStrength", 0);
  out.anisotropy_rotation = number_or(from, "anisotropyRotation", 0);
  out.anisotropy_direction = member_texture(from, "anisotropyTexture", ColorSpace::linear, place);
}

std::optional<TextureUse> Materials::member_texture(const tinygltf::Value& object,
                                                    const std::string& key, ColorSpace space,
                                                    const std::string& place) {
  const tinygltf::Value* texture = member(object, key);
  if (texture == nullptr) return std::nullopt;
  tinygltf::ExtensionMap extensions;
  if (const auto* all = member(*texture, "extensions"); all != nullptr && all->IsObject())
    if (const auto* transform = member(*all, "KHR_texture_transform"))
      extensions.emplace("KHR_texture_transform", *transform);
  return use_texture({.texture = integer_or(*texture, "index", -1),
                      .uv_set = integer_or(*texture, "texCoord", 0),
                      .extensions = &extensions,
                      .place = place + ": " + key},
                     space);
}

std::optional<TextureUse> Materials::use_texture(const Use& use, ColorSpace space) {
  if (use.texture < 0) return std::nullopt;
  const tinygltf::Texture& texture = asset_.model.textures[static_cast<std::size_t>(use.texture)];
  int image = texture.source;
  if (const auto* webp = extension(texture.extensions, "EXT_texture_webp"))
    image = integer_or(*webp, "source", image);
  if (image < 0) {
    asset_.warn(
        fmt::format("/textures/{} has no image in a format that is supported, and is left "
                    "out",
                    use.texture));
    return std::nullopt;
  }
  TextureUse out;
  int uv_set = use.uv_set;
  if (const auto* transform = extension(*use.extensions, "KHR_texture_transform")) {
    out.to_uv = transform_of(*transform);
    uv_set = integer_or(*transform, "texCoord", uv_set);
  }
  if (uv_set > 1) {
    asset_.warn(
        fmt::format("{} wants texture coordinates of set {}; 0 and 1 are supported, and it "
                    "is left out",
                    use.place, uv_set));
    return std::nullopt;
  }
  out.uv_set = static_cast<std::uint8_t>(uv_set);
  out.texture = texture_index(use.texture, space, image);
  return out;
}

std::uint32_t Materials::texture_index(int number, ColorSpace space, int image) {
  const auto [found, fresh] = known_textures_.try_emplace(
      std::pair(number, space), static_cast<std::uint32_t>(textures_.size()));
  if (!fresh) return found->second;
  const auto [at, fresh_image] =
      known_images_.try_emplace(image, static_cast<std::uint32_t>(images_.size()));
  if (fresh_image) images_.push_back(asset_.images[static_cast<std::size_t>(image)]);
  const int sampler = asset_.model.textures[static_cast<std::size_t>(number)].sampler;
  Texture out{.image = at->second, .color_space = space};
  if (sampler >= 0) {
    const tinygltf::Sampler& from = asset_.model.samplers[static_cast<std::size_t>(sampler)];
    out.wrap_u = wrap_of(from.wrapS);
    out.wrap_v = wrap_of(from.wrapT);
    out.nearest = from.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
  }
  textures_.push_back(out);
  return found->second;
}

}  // namespace tessera::scene::gltf
