#pragma once
#include <algorithm>
#include <cmath>
#include <optional>

#include "worker/render/bsdf/inputs.hpp"

namespace tessera::render {

/// The normal nearest to `n` that lets light from wo, mirrored at it, leave the surface on wo's
/// side; for where `n` does not. `geometric` is on n's side.
Vec3 turned_outside(const Vec3& n, const Vec3& geometric, const Vec3& wo);

/// How high above the surface light from wo is to leave it, mirrored: a hundredth, less where wo
/// itself is as low, so that no surface's own normal is turned.
inline float least_height(const Vec3& geometric, const Vec3& wo) {
  return std::min(0.01F, 0.9F * std::abs(dot(wo, geometric)));
}

/// `n` if light from wo, mirrored at it, stays on wo's side of the surface; else the one next to it
/// that does so. Normals, interpolated or bent by maps, that mirror into the surface would be black
/// there, as black edges where a surface is seen at an angle (Keller et al., "The Iray Light
/// Transport Simulation and Rendering System", 2017, appendix A.3, has the same idea).
inline Vec3 keep_mirrored_outside(const Vec3& n, const Vec3& geometric, const Vec3& wo) {
  const float out = dot(wo, geometric), mirrored = 2 * dot(n, wo) * dot(n, geometric) - out;
  return (out < 0 ? -mirrored : mirrored) >= least_height(geometric, wo)
             ? n
             : turned_outside(n, geometric, wo);
}

/// A normal from a tangent-space map.
struct NormalSlot {
  TextureUse texture;
  float scale = 1;

  explicit NormalSlot(const scene::NormalMap& map)
      : texture(compile(map.texture)), scale(static_cast<float>(map.scale)) {}
  /// The shading frame that it gives; the hit's own where there are no tangents or
  /// no coordinates.
  [[nodiscard]] Frame frame(const Source& source) const;
};

/// A normal from heights.
struct BumpSlot {
  TextureUse texture;
  float height = 1;

  explicit BumpSlot(const scene::BumpMap& map)
      : texture(compile(map.texture)), height(static_cast<float>(map.height)) {}
  /// The frame that it gives over `shading`, from differences over a texel, or over the ray's
  /// footprint where that is wider; `shading` itself where there are no tangents or no coordinates.
  [[nodiscard]] Frame frame(const Source& source, const Frame& shading) const;
};

}  // namespace tessera::render
