#pragma once
#include <cmath>

#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/bsdf/lobe_sample.hpp"
#include "worker/render/warp.hpp"

/// Lambert's lobe, on whichever side wo is: f = albedo / π.
namespace tessera::render::diffuse {

/// With the cosine; black where wi and wo are on different sides.
inline Color eval(const Lobe& lobe, const Vec3& wo, const Vec3& wi) {
  return wo.z * wi.z > 0 ? lobe.weight * (inv_pi * std::abs(wi.z)) : Color{};
}

inline float pdf(const Vec3& wo, const Vec3& wi) {
  return wo.z * wi.z > 0 ? inv_pi * std::abs(wi.z) : 0;
}

/// By the cosine, so that the weight is the albedo itself.
inline LobeSample sample(const Lobe& lobe, const Vec3& wo, Vec2 u) {
  if (wo.z == 0) return {};
  Vec3 wi = square_to_cosine_hemisphere(u);
  const float density = cosine_hemisphere_pdf(wi);
  if (wo.z < 0) wi.z = -wi.z;
  return {.wi = wi, .weight = lobe.weight, .pdf = density};
}

}  // namespace tessera::render::diffuse
