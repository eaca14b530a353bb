#pragma once
#include <algorithm>
#include <optional>

#include "common/scene/texture.hpp"
#include "worker/render/bsdf/shading_point.hpp"
#include "worker/render/textures/texture_table.hpp"

/// Inputs of a material as its program reads them, once per hit: a literal, times a texture where
/// there is one.
namespace tessera::render {

/// What inputs are read from.
struct Source {
  const ShadingPoint& point;
  const TextureTable& textures;
};

struct ColorSlot {
  Color factor;
  std::optional<TextureUse> texture;

  ColorSlot() = default;
  explicit ColorSlot(const scene::ColorInput& input) : factor(to_color(input.factor)) {
    if (input.texture) texture = compile(*input.texture);
  }
  [[nodiscard]] Color at(const Source& source) const {
    if (!texture) return factor;
    const Texel texel = source.textures.lookup(*texture, source.point.detail);
    return factor * Color{texel[0], texel[1], texel[2]};
  }
};

struct ScalarSlot {
  float factor = 0;
  std::optional<TextureUse> texture;
  std::uint8_t channel = 0;

  ScalarSlot() = default;
  explicit ScalarSlot(const scene::ScalarInput& input)
      : factor(static_cast<float>(input.factor)), channel(input.channel) {
    if (input.texture) texture = compile(*input.texture);
  }
  [[nodiscard]] float at(const Source& source) const {
    if (!texture) return factor;
    return factor * source.textures.lookup(*texture, source.point.detail)[channel];
  }
};

/// The detail_flag that a texture needs.
constexpr std::uint8_t wanted_by(std::uint8_t uv_set) {
  return uv_set == 0 ? detail_flag::uv0 : detail_flag::uv1;
}
/// The detail_flags of tangents that follow a set.
constexpr std::uint8_t tangents_by(std::uint8_t uv_set) {
  return uv_set == 0 ? detail_flag::tangent : detail_flag::tangent | detail_flag::tangent_by_uv1;
}
/// `wanted`, and what a map of normals needs: its tangents count, as there is one set of them.
constexpr unsigned with_tangents_of(const TextureUse& map, unsigned wanted) {
  return (wanted & ~unsigned{detail_flag::tangent_by_uv1}) | wanted_by(map.uv_set) |
         tangents_by(map.uv_set);
}
template <class Slot>
std::uint8_t wanted_by(const Slot& slot) {
  return slot.texture ? wanted_by(slot.texture->uv_set) : std::uint8_t{0};
}

inline float unit(float value) { return std::clamp(value, 0.0F, 1.0F); }
inline Color unit(const Color& c) { return {unit(c.r), unit(c.g), unit(c.b)}; }

}  // namespace tessera::render
