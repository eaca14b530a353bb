#pragma once
#include <algorithm>
#include <cmath>

#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/bsdf/fresnel.hpp"
#include "worker/render/bsdf/lobe_sample.hpp"

/// Smooth interface: two deltas, reflection and refraction, chosen by what each carries. z points
/// to the outer side.
namespace tessera::render::dielectric {

/// `u` chooses. A refraction's weight holds 1/eta² (radiance transport; Veach 1997, section 5.2),
/// eta being the index on wi's side over that on wo's.
inline LobeSample sample(const Lobe& lobe, const Vec3& wo, float u) {
  const float eta = wo.z > 0 ? lobe.ior : 1 / lobe.ior;
  const Fresnel fresnel = fresnel_dielectric(std::min(1.0F, std::abs(wo.z)), eta);
  const Color reflected = lobe.weight * fresnel.reflectance;
  const Color refracted = lobe.tint * (1 - fresnel.reflectance);
  const float reflected_share = max_component(reflected);
  const float total = reflected_share + max_component(refracted);
  if (!(total > 0) || wo.z == 0) return {};
  const float probability = reflected_share / total;
  if (u < probability) {
    return {.wi = {-wo.x, -wo.y, wo.z}, .weight = reflected / probability, .pdf = probability};
  }
  const Vec3 wi = {-wo.x / eta, -wo.y / eta, std::copysign(fresnel.cos_transmitted, -wo.z)};
  const float rest = 1 - probability;
  if (!(rest > 0)) return {};
  return {.wi = normalize(wi),
          .weight = refracted / (rest * eta * eta),
          .pdf = rest,
          .eta = eta,
          .transmission = true};
}

}  // namespace tessera::render::dielectric
