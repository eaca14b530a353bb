#include "common/scene/texture_uses.hpp"

#include <cstddef>
#include <cstdint>
#include <variant>

namespace tessera::scene {

namespace {

/// Calls `take` with each use of a texture.
template <class SomeMaterial, class Take>
void each_use(SomeMaterial& material, const Take& take) {
  const auto if_any = [&](auto& use) {
    if (use) take(*use);
  };
  if (auto* surface = std::get_if<Principled>(&material.surface)) {
    for (auto* input : {&surface->base_color, &surface->specular_color, &surface->emission})
      if_any(input->texture);
    for (auto* input :
         {&surface->metallic, &surface->roughness, &surface->specular, &surface->transmission,
          &surface->clearcoat, &surface->clearcoat_roughness, &surface->anisotropy})
      if_any(input->texture);
    if_any(surface->anisotropy_direction);
    if (surface->clearcoat_normal) take(surface->clearcoat_normal->texture);
  }
  if (auto* mix = std::get_if<Mix>(&material.surface)) if_any(mix->amount.texture);
  if_any(material.opacity.alpha.texture);
  if (material.normal_map) take(material.normal_map->texture);
  if (material.bump_map) take(material.bump_map->texture);
}

/// Reflects otherwise along than across, by directions of the first coordinates.
bool is_brushed(const Material& material) {
  // At the full roughness both ways are alike.
  if (const auto* metal = std::get_if<Conductor>(&material.surface))
    return metal->anisotropy > 0 && metal->roughness < 1;
  const auto* surface = std::get_if<Principled>(&material.surface);
  return surface != nullptr && surface->anisotropy.factor > 0 && !surface->anisotropy_direction;
}

}  // namespace

std::vector<TextureUse*> texture_uses(Material& material) {
  std::vector<TextureUse*> out;
  each_use(material, [&](TextureUse& use) { out.push_back(&use); });
  return out;
}

std::array<bool, 2> coordinate_sets(const Material& material, std::span<const Material> all) {
  std::array<bool, 2> out{is_brushed(material), false};
  each_use(material, [&](const TextureUse& use) { out.at(use.uv_set) = true; });
  if (const auto* mix = std::get_if<Mix>(&material.surface))
    for (const std::uint32_t part : {mix->first, mix->second}) {
      const std::array<bool, 2> of_part = coordinate_sets(all[part], all);
      for (std::size_t set = 0; set < out.size(); ++set)
        out.at(set) = out.at(set) || of_part.at(set);
    }
  return out;
}

}  // namespace tessera::scene
