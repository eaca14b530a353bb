#pragma once
#include <algorithm>
#include <cmath>
#include <optional>

#include "worker/render/bsdf/inputs.hpp"
#include "worker/render/bsdf/microfacet.hpp"

/// What surfaces of microfacets have in common at a hit.
namespace tessera::render {

inline float cosine_to(const Frame& frame, const Source& source) {
  return dot(source.point.wo, frame.n);
}
inline float facing(const Frame& frame, const Source& source) {
  return std::min(1.0F, std::abs(cosine_to(frame, source)));
}

/// KHR_materials_anisotropy: αt = mix(r², 1, strength²), αb = r².
inline ggx::Roughness roughness_of(float roughness, float strength = 0) {
  const float alpha = roughness * roughness;
  return {alpha + (1 - alpha) * strength * strength, alpha};
}

/// The unit vector at an angle, in radians counter-clockwise from the first axis.
Vec2 direction_of(float angle);

/// energy::bounce() of a surface, made once, for hits to look up; none of a mirror or of what is
/// brushed.
inline std::optional<energy::BounceRow> bounces_of(const microfacet::Surface& surface) {
  const ggx::Roughness& roughness = surface.roughness;
  if (surface.smooth || roughness.alpha_x != roughness.alpha_y) return std::nullopt;
  return energy::BounceRow(roughness.alpha_x);
}

/// Microfacets at a hit, in a frame of their own where they are brushed: along `direction`, of any
/// length, by the surface's tangent and across.
struct Layer {
  std::optional<Frame> brushed;  ///< none: they stand in the shading frame
  microfacet::View view;

  Layer(const Source& source, const Frame& shading, const ggx::Roughness& roughness,
        Vec2 direction);
  /// Of a surface whose bounces were made: they have no direction.
  Layer(const Source& source, const Frame& shading, const energy::BounceRow& bounces)
      : view(microfacet::view_of(bounces, facing(shading, source))) {}
  /// Adds a lobe of these microfacets, which is chosen by its albedo.
  void add(const Lobe& lobe, const Color& albedo, Closure& out) const {
    if (lobe.alpha_x == lobe.alpha_y) {
      out.add(lobe, max_component(albedo));
    } else {
      add_brushed(lobe, max_component(albedo), out);
    }
  }

 private:
  void add_brushed(const Lobe& lobe, float weight, Closure& out) const;
};

/// What light meets that goes straight through a thin wall, or nearly so: as rough as the wall is
/// across, whatever way it is brushed.
microfacet::Surface passing_of(const ggx::Roughness& roughness);
/// Adds such light: of `color`, seen at a cosine of 0…1.
void add_passing(float cosine, const Color& color, const microfacet::Surface& passing,
                 Closure& out);

}  // namespace tessera::render
