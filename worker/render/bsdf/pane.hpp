#pragma once
#include <algorithm>
#include <cmath>

#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/bsdf/fresnel.hpp"
#include "worker/render/bsdf/lobe_sample.hpp"

/// A smooth thin wall, seen as one surface: two deltas, on both sides alike.
namespace tessera::render::pane {

/// What both faces of a wall reflect together, of which each reflects `face`: 2R/(1 + R).
constexpr float both_faces(float face) { return 2 * face / (1 + face); }

/// `u` chooses. What passes goes straight on.
inline LobeSample sample(const Lobe& lobe, const Vec3& wo, float u) {
  if (wo.z == 0) return {};
  const float face = fresnel_dielectric(std::min(1.0F, std::abs(wo.z)), lobe.ior).reflectance;
  const float reflectance = both_faces(face);
  const Color reflected = lobe.weight * reflectance, passed = lobe.tint * (1 - reflectance);
  const float share = max_component(reflected), total = share + max_component(passed);
  if (!(total > 0)) return {};
  const float probability = share / total;
  if (u < probability) {
    return {.wi = {-wo.x, -wo.y, wo.z}, .weight = reflected / probability, .pdf = probability};
  }
  const float rest = 1 - probability;
  if (!(rest > 0)) return {};
  return {.wi = -wo, .weight = passed / rest, .pdf = rest, .transmission = true};
}

}  // namespace tessera::render::pane
