#pragma once
#include <optional>
#include <variant>

#include "common/scene/material.hpp"
#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/bsdf/inputs.hpp"
#include "worker/render/bsdf/microfacet.hpp"
#include "worker/render/bsdf/principled.hpp"

/// Surfaces whose lobes depend on wo or on textures: at a hit each adds its lobes, up to four so
/// that a mix of two fits, to a closure whose shading frame is set. `wants` is what they look at
/// (detail_flag).
namespace tessera::render {

struct ConductorSurface {
  explicit ConductorSurface(const scene::Conductor& source);
  void add(const Source& source, Closure& out) const;

  [[nodiscard]] std::uint8_t wants() const {
    return surface.roughness.alpha_x != surface.roughness.alpha_y ? detail_flag::tangent : 0;
  }

  microfacet::Surface surface;
  Vec2 direction;                            ///< in which it is brushed
  std::optional<energy::BounceRow> bounces;  ///< of `surface`; if brushed or a mirror, none
};

struct DielectricSurface {
  explicit DielectricSurface(const scene::Dielectric& source);
  void add(const Source& source, Closure& out) const;

  [[nodiscard]] static std::uint8_t wants() { return 0; }

  Color reflectance, transmittance;
  float ior = 1;
  ggx::Roughness roughness;
  bool thin_walled = false;
  microfacet::Surface faces;    ///< of a thin wall, both together
  microfacet::Surface passing;  ///< the same wall, for what passes it
};

/// Ends a part of a mix: what was added since the last such step is multiplied by its share.
struct MixStep {
  [[nodiscard]] std::uint8_t wants() const { return wanted_by(amount); }

  ScalarSlot amount;
  bool second = false;
};

using Surface = std::variant<ConductorSurface, DielectricSurface, PrincipledSurface, MixStep>;

}  // namespace tessera::render
