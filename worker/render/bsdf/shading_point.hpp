#pragma once
#include <optional>

#include "worker/render/frame.hpp"
#include "worker/render/surface_detail.hpp"
#include "worker/render/vec.hpp"

namespace tessera::render {

/// What a material may look at.
struct ShadingPoint {
  Vec3 wo;                ///< unit, away from the surface
  Vec3 normal{0, 0, 1};   ///< geometric, unit, outer side
  Frame shading;          ///< n on the side of `normal`
  bool rounded = false;   ///< its n is interpolated: the face stands for something round
  float footprint = 0;    ///< width of the ray's cone here, for texture filtering
  float outside_ior = 1;  ///< of what a dielectric here borders on, on the outer side
  /// What CompiledMaterial::wants asked for, where the geometry has any of it.
  std::optional<SurfaceDetail> detail;
};

}  // namespace tessera::render
