#include "worker/render/bsdf/microfacet.hpp"

#include <algorithm>
#include <cmath>

#include "worker/render/bsdf/brushed_energy.hpp"
#include "worker/render/warp.hpp"

namespace tessera::render::microfacet {
namespace {

bool is_smooth(const ggx::Roughness& r) {
  return std::max(r.alpha_x, r.alpha_y) < ggx::alpha_smooth;
}

/// The reflectance of all bounces after the first, where `mean` is one bounce's and `energy` what
/// escapes at each: Σ mean^(n+1)·energy·(1 − energy)^(n−1).
Color later_bounces(const Color& mean, float energy) {
  const auto of = [energy](float f) { return f * f * energy / (1 - f * (1 - energy)); };
  return {of(mean.r), of(mean.g), of(mean.b)};
}

struct Sides {
  Vec3 wo, wi;  ///< both turned up
  bool meet = false;
};
/// Turned so that the lobe only ever reflects upwards.
Sides turned_up(const Lobe& lobe, const Vec3& wo, const Vec3& wi) {
  const bool through = lobe.kind == LobeKind::microfacet_through;
  const bool same = wo.z * wi.z > 0;
  Sides out{wo, wi, through ? wo.z * wi.z < 0 : same};
  out.wo.z = std::abs(wo.z);
  out.wi.z = std::abs(wi.z);
  return out;
}

Reflectance reflectance_of(const Lobe& lobe) {
  return lobe.kind == LobeKind::microfacet ? Reflectance{lobe.weight, lobe.tint, lobe.dip}
                                           : Reflectance{lobe.weight, {}, {}};
}

}  // namespace

Lobe lobe_of(const Parameters& p, bool through) {
  if (is_smooth(p.roughness)) {
    return {.kind = LobeKind::mirror,
            .weight = p.reflectance.at(p.wo.cosine),
            .tint = p.reflectance.normal};
  }
  const float mean = energy::reflection_mean(p.roughness);
  const float lost = 1 - energy::reflection(p.wo, p.roughness);
  const Color later = later_bounces(p.reflectance.mean(), mean);
  return {.kind = through ? LobeKind::microfacet_through : LobeKind::microfacet,
          .weight = p.reflectance.normal,
          .tint = p.reflectance.rise,
          .alpha_x = std::max(p.roughness.alpha_x, ggx::alpha_smooth),
          .alpha_y = std::max(p.roughness.alpha_y, ggx::alpha_smooth),
          .dip = p.reflectance.dip,
          .multiple = later * (lost * inv_pi / std::max(1 - mean, 1e-6F)),
          .multiple_share = std::clamp(lost, 0.0F, 1.0F)};
}

Color albedo(const Parameters& p) {
  if (is_smooth(p.roughness)) return p.reflectance.at(p.wo.cosine);
  const float once = energy::reflection(p.wo, p.roughness);
  const Color later = later_bounces(p.reflectance.mean(), energy::reflection_mean(p.roughness));
  const float schlick = energy::schlick_mean(p.wo, p.roughness);
  return (p.reflectance.normal + p.reflectance.rise * schlick) * once + later * (1 - once);
}

Color eval(const Lobe& lobe, const Vec3& wo, const Vec3& wi) {
  const Sides at = turned_up(lobe, wo, wi);
  if (!at.meet) return {};
  const ggx::Roughness roughness{lobe.alpha_x, lobe.alpha_y};
  const Vec3 m = normalize(at.wo + at.wi);
  const Color once = reflectance_of(lobe).at(dot(at.wo, m)) *
                     (ggx::distribution(roughness, m) *
                      ggx::masking_over_cosines(roughness, at.wo, at.wi) * at.wi.z * 0.25F);
  if (!(lobe.multiple_share > 0)) return once;
  const float lost = 1 - energy::reflection(energy::slant_of(at.wi), roughness);
  return once + lobe.multiple * (lost * at.wi.z);
}

float pdf(const Lobe& lobe, const Vec3& wo, const Vec3& wi) {
  const Sides at = turned_up(lobe, wo, wi);
  if (!at.meet) return 0;
  const ggx::Roughness roughness{lobe.alpha_x, lobe.alpha_y};
  const Vec3 m = normalize(at.wo + at.wi);
  const float once =
      ggx::distribution(roughness, m) * ggx::masking_over_cosine(roughness, at.wo) * 0.25F;
  return (1 - lobe.multiple_share) * once + lobe.multiple_share * inv_pi * at.wi.z;
}

LobeSample sample(const Lobe& lobe, const Vec3& wo, float u_part, Vec2 u) {
  if (wo.z == 0) return {};
  const Vec3 up{wo.x, wo.y, std::abs(wo.z)};
  Vec3 wi;
  if (u_part < lobe.multiple_share) {
    wi = square_to_cosine_hemisphere(u);
  } else {
    const Vec3 m = ggx::sample_visible_normal({lobe.alpha_x, lobe.alpha_y}, up, u);
    wi = normalize(m * (2 * dot(up, m)) - up);
    if (!(wi.z > 0)) return {};
  }
  const bool through = lobe.kind == LobeKind::microfacet_through;
  if ((wo.z < 0) != through) wi.z = -wi.z;
  const float density = pdf(lobe, wo, wi);
  if (!(density > 0)) return {};
  return {
      .wi = wi, .weight = eval(lobe, wo, wi) / density, .pdf = density, .transmission = through};
}

}  // namespace tessera::render::microfacet
