#include "worker/render/bsdf/microfacet.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "worker/render/bsdf/brushed_energy.hpp"
#include "worker/render/warp.hpp"

namespace tessera::render::microfacet {
namespace {

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

Surface surface_of(const Reflectance& reflectance, const ggx::Roughness& roughness) {
  Surface out{.reflectance = reflectance,
              .roughness = roughness,
              .smooth = ggx::is_smooth(roughness),
              .later = {}};
  if (out.smooth) return out;
  out.mean = energy::reflection_mean(roughness);
  out.later = later_bounces(reflectance.mean(), out.mean);
  out.spread = inv_pi / std::max(1 - out.mean, 1e-6F);
  return out;
}

View view_of(const ggx::Roughness& roughness, const energy::Slant& wo) {
  if (ggx::is_smooth(roughness)) return {.cosine = wo.cosine};
  return {.cosine = wo.cosine, .once = energy::bounce(wo, roughness)};
}

Lobe lobe_of(const Surface& surface, const View& view, bool through) {
  const Reflectance& reflectance = surface.reflectance;
  assert(!through || !surface.smooth);
  if (surface.smooth) {
    return {.kind = LobeKind::mirror,
            .weight = reflectance.at(view.cosine),
            .tint = reflectance.normal};
  }
  const float lost = 1 - view.once.albedo;
  return {.kind = through ? LobeKind::microfacet_through : LobeKind::microfacet,
          .weight = reflectance.normal,
          .tint = reflectance.rise,
          .alpha_x = std::max(surface.roughness.alpha_x, ggx::alpha_smooth),
          .alpha_y = std::max(surface.roughness.alpha_y, ggx::alpha_smooth),
          .dip = reflectance.dip,
          .multiple = surface.later * (lost * surface.spread),
          .multiple_share = std::clamp(lost, 0.0F, 1.0F)};
}

Color albedo(const Surface& surface, const View& view) {
  const Reflectance& reflectance = surface.reflectance;
  if (surface.smooth) return reflectance.at(view.cosine);
  return (reflectance.normal + reflectance.rise * view.once.schlick) * view.once.albedo +
         surface.later * (1 - view.once.albedo);
}

Scattering scattering(const Lobe& lobe, const Vec3& wo, const Vec3& wi) {
  const Sides at = turned_up(lobe, wo, wi);
  if (!at.meet) return {};
  const ggx::Roughness roughness{lobe.alpha_x, lobe.alpha_y};
  const Vec3 m = normalize(at.wo + at.wi);
  const float quarter = ggx::distribution(roughness, m) * 0.25F;
  const float once = quarter * ggx::masking_over_cosine(roughness, at.wo);
  Scattering out{.value = reflectance_of(lobe).at(dot(at.wo, m)) *
                          (quarter * ggx::masking_over_cosines(roughness, at.wo, at.wi) * at.wi.z),
                 .pdf = once};
  if (!(lobe.multiple_share > 0)) return out;
  const float lost = 1 - energy::reflection(at.wi, roughness);
  out.value += lobe.multiple * (lost * at.wi.z);
  out.pdf = (1 - lobe.multiple_share) * once + lobe.multiple_share * inv_pi * at.wi.z;
  return out;
}

Vec3 draw(const Lobe& lobe, const Vec3& wo, float u_part, Vec2 u) {
  if (wo.z == 0) return {};
  Vec3 wi;
  if (u_part < lobe.multiple_share) {
    wi = square_to_cosine_hemisphere(u);
  } else {
    const Vec3 up{wo.x, wo.y, std::abs(wo.z)};
    const Vec3 m = ggx::sample_visible_normal({lobe.alpha_x, lobe.alpha_y}, up, u);
    wi = normalize(m * (2 * dot(up, m)) - up);
    if (!(wi.z > 0)) return {};
  }
  const bool through = lobe.kind == LobeKind::microfacet_through;
  if ((wo.z < 0) != through) wi.z = -wi.z;
  return wi;
}

LobeSample sample(const Lobe& lobe, const Vec3& wo, float u_part, Vec2 u) {
  const Vec3 wi = draw(lobe, wo, u_part, u);
  const Scattering at = scattering(lobe, wo, wi);
  if (!(at.pdf > 0)) return {};
  return {.wi = wi,
          .weight = at.value / at.pdf,
          .pdf = at.pdf,
          .transmission = lobe.kind == LobeKind::microfacet_through};
}

}  // namespace tessera::render::microfacet
