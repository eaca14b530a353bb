#pragma once
#include <optional>

#include "worker/render/bsdf/inputs.hpp"

namespace tessera::render {

/// `n` if light from wo, mirrored at it, stays on wo's side of the surface; else the normal nearest
/// to it that just lets it. Bent normals that mirror into the surface would be black there, as
/// black edges where a surface is seen at an angle (Keller et al., "The Iray Light Transport
/// Simulation and Rendering System", 2017, appendix A.3, has the same idea). `geometric` is on
/// n's side.
Vec3 keep_mirrored_outside(const Vec3& n, const Vec3& geometric, const Vec3& wo);

/// A normal from a tangent-space map.
struct NormalSlot {
  TextureUse texture;
  float scale = 1;

  explicit NormalSlot(const scene::NormalMap& map)
      : texture(compile(map.texture)), scale(static_cast<float>(map.scale)) {}
  /// The shading frame that it gives; the hit's own where there are no coordinates.
  [[nodiscard]] Frame frame(const Source& source) const;
};

/// A normal from heights.
struct BumpSlot {
  TextureUse texture;
  float height = 1;

  explicit BumpSlot(const scene::BumpMap& map)
      : texture(compile(map.texture)), height(static_cast<float>(map.height)) {}
  /// The frame that it gives over `shading`, from differences over a texel, or over the ray's
  /// footprint where that is wider.
  [[nodiscard]] Frame frame(const Source& source, const Frame& shading) const;
};

}  // namespace tessera::render
