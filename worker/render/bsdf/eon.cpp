#include "worker/render/bsdf/eon.hpp"

#include <algorithm>
#include <cmath>

#include "worker/render/warp.hpp"

namespace tessera::render::eon {
namespace {

// Of the Fujii form of Oren and Nayar's model: 1/2 − 2/(3π) and 2/3 − 28/(15π).
constexpr float from_normal = 0.28779341F, on_average = 0.07248818F;

constexpr float scale(float roughness) { return 1 / (1 + from_normal * roughness); }
/// Directional albedo for a white surface, by the paper's fit.
constexpr float white_albedo(float cosine, float roughness) {
  const float m = 1 - cosine;
  const float g =
      m * (0.0571085289F + m * (0.491881867F + m * (-0.332181442F + m * 0.0714429953F)));
  return scale(roughness) * (1 + roughness * g);
}
constexpr float mean_albedo(float roughness) {
  return scale(roughness) * (1 + on_average * roughness);
}

}  // namespace

/// With the cosine; black where wi and wo are on different sides.
Color eval(const Lobe& lobe, const Vec3& wo, const Vec3& wi) {
  if (!(wo.z * wi.z > 0)) return {};
  const float roughness = lobe.alpha_x;
  const float cos_o = std::abs(wo.z), cos_i = std::abs(wi.z);
  const float s = wo.x * wi.x + wo.y * wi.y;
  const float s_over_t = s > 0 ? s / std::max(cos_o, cos_i) : s;
  const float once = scale(roughness) * (1 + roughness * s_over_t);
  const float mean = mean_albedo(roughness);
  const float later = std::max(0.0F, 1 - white_albedo(cos_o, roughness)) *
                      std::max(0.0F, 1 - white_albedo(cos_i, roughness)) /
                      std::max(1e-7F, 1 - mean);
  const auto of = [&](float rho) {
    return rho * once + rho * rho * mean / (1 - rho * (1 - mean)) * later;
  };
  return Color{of(lobe.weight.r), of(lobe.weight.g), of(lobe.weight.b)} * lobe.tint *
         (inv_pi * cos_i);
}

float pdf(const Vec3& wo, const Vec3& wi) { return wo.z * wi.z > 0 ? inv_pi * std::abs(wi.z) : 0; }

LobeSample sample(const Lobe& lobe, const Vec3& wo, Vec2 u) {
  if (wo.z == 0) return {};
  Vec3 wi = square_to_cosine_hemisphere(u);
  const float density = cosine_hemisphere_pdf(wi);
  if (wo.z < 0) wi.z = -wi.z;
  return {.wi = wi, .weight = eval(lobe, wo, wi) / density, .pdf = density};
}

}  // namespace tessera::render::eon
