#include "worker/render/bsdf/rough_dielectric.hpp"

#include <algorithm>
#include <cmath>

#include "worker/render/bsdf/energy.hpp"
#include "worker/render/bsdf/fresnel.hpp"
#include "worker/render/warp.hpp"

namespace tessera::render::rough_dielectric {
namespace {

float mean_alpha(const ggx::Roughness& r) {
  return r.alpha_x == r.alpha_y ? r.alpha_x : std::sqrt(r.alpha_x * r.alpha_y);
}

/// Seen with wo above: what is on the far side of it is below.
struct View {
  Vec3 wo, wi;
  float eta = 1;  ///< index below over that above
  bool refracted = false;
};
View view_of(const Lobe& lobe, const Vec3& wo, const Vec3& wi) {
  View view{wo, wi, wo.z > 0 ? lobe.ior : 1 / lobe.ior, wo.z * wi.z < 0};
  if (wo.z < 0) {
    view.wo.z = -view.wo.z;
    view.wi.z = -view.wi.z;
  }
  return view;
}

/// The microfacet that leads from one to the other, and how.
struct Facet {
  Vec3 m;
  float cos_o = 0, cos_i = 0;  ///< of both against m
  float reflectance = 1;
  float share = 1;  ///< the chance with which it is taken to reflect
};

float reflected_share(const Lobe& lobe, float reflectance) {
  const float up = reflectance * max_component(lobe.weight);
  const float total = up + (1 - reflectance) * max_component(lobe.tint);
  return total > 0 ? up / total : 0;
}

/// False if no microfacet does.
bool find_facet(const Lobe& lobe, const View& at, Facet& facet) {
  facet.m = normalize(at.refracted ? at.wo + at.wi * at.eta : at.wo + at.wi);
  if (facet.m.z < 0) facet.m = -facet.m;
  facet.cos_o = dot(at.wo, facet.m);
  facet.cos_i = dot(at.wi, facet.m);
  if (!(facet.cos_o > 0) || at.refracted != (facet.cos_i < 0)) return false;
  facet.reflectance = fresnel_dielectric(std::min(facet.cos_o, 1.0F), at.eta).reflectance;
  facet.share = reflected_share(lobe, facet.reflectance);
  return true;
}

/// The solid angle of m for that of a refracted wi.
float refraction_jacobian(const Facet& facet, float eta) {
  const float span = facet.cos_o + eta * facet.cos_i;
  return eta * eta * std::abs(facet.cos_i) / (span * span);
}

/// How light that meets microfacets more than once goes on, seen from one side.
struct Later {
  float reflected = 1;  ///< the rest passes
  float here = 0;       ///< what is lost by single bounces on this side, on average
  float there = 0;      ///< … on the other side
};
/// Both directions of a path agree where passed·here = η²·passed'·there, ' being the other side's.
Later later_of(float alpha, float eta) {
  const float here = std::max(1 - energy::interface_mean(alpha, eta), 1e-6F);
  const float there = std::max(1 - energy::interface_mean(alpha, 1 / eta), 1e-6F);
  const float thin = eta >= 1 ? here : there, dense = eta >= 1 ? there : here;
  const float ratio = eta >= 1 ? eta : 1 / eta;
  // The mean of Fresnel's reflectance from the thin side, as Kulla and Conty fit it.
  const float from_thin = 1 - (ratio - 1) / (4.08567F + 1.00071F * ratio);
  const float from_dense = from_thin * thin / (ratio * ratio * dense);
  const float too_much = std::max(1.0F, from_dense);
  const float passed = (eta >= 1 ? from_thin : from_dense) / too_much;
  return {1 - passed, here, there};
}

}  // namespace

Lobe lobe_of(const Parameters& p) {
  Lobe lobe{
      .kind = LobeKind::dielectric, .weight = p.reflectance, .tint = p.transmittance, .ior = p.ior};
  if (ggx::is_smooth(p.roughness) || std::abs(p.ior - 1) < 1e-3F) return lobe;
  lobe.kind = LobeKind::rough_dielectric;
  lobe.alpha_x = std::max(p.roughness.alpha_x, ggx::alpha_smooth);
  lobe.alpha_y = std::max(p.roughness.alpha_y, ggx::alpha_smooth);
  const float alpha = mean_alpha(p.roughness), eta = p.cos_o > 0 ? p.ior : 1 / p.ior;
  const Later later = later_of(alpha, eta);
  const float lost = 1 - energy::interface(std::abs(p.cos_o), alpha, eta);
  lobe.multiple = {later.reflected * lost * inv_pi / later.here,
                   (1 - later.reflected) * lost * inv_pi / later.there, later.reflected};
  lobe.multiple_share = std::clamp(lost, 0.0F, 1.0F);
  return lobe;
}

Scattering scattering(const Lobe& lobe, const Vec3& wo, const Vec3& wi) {
  if (wo.z * wi.z == 0) return {};
  const View at = view_of(lobe, wo, wi);
  const ggx::Roughness roughness{lobe.alpha_x, lobe.alpha_y};
  const float cos_i = std::abs(at.wi.z), eta_squared = at.eta * at.eta;
  float value = 0, once = 0;
  Facet facet;
  if (find_facet(lobe, at, facet)) {
    const float distribution = ggx::distribution(roughness, facet.m);
    const float common = distribution * ggx::masking_over_cosines(roughness, at.wo, at.wi) * cos_i;
    const float seen = distribution * ggx::masking_over_cosine(roughness, at.wo);
    if (at.refracted) {
      const float bent = facet.cos_o * refraction_jacobian(facet, at.eta);
      value = (1 - facet.reflectance) * common * bent / eta_squared;
      once = (1 - facet.share) * seen * bent;
    } else {
      value = facet.reflectance * common * 0.25F;
      once = facet.share * seen * 0.25F;
    }
  }
  const float alpha = mean_alpha(roughness);
  const float side = at.refracted ? 1 - lobe.multiple.b : lobe.multiple.b;
  Scattering out;
  out.pdf = (1 - lobe.multiple_share) * once + lobe.multiple_share * side * inv_pi * cos_i;
  if (at.refracted) {
    const float lost = 1 - energy::interface(cos_i, alpha, 1 / at.eta);
    out.value = lobe.tint * (value + lobe.multiple.g * lost * cos_i / eta_squared);
  } else {
    const float lost = 1 - energy::interface(cos_i, alpha, at.eta);
    out.value = lobe.weight * (value + lobe.multiple.r * lost * cos_i);
  }
  return out;
}

LobeSample sample(const Lobe& lobe, const Vec3& wo, float u_part, Vec2 u) {
  if (wo.z == 0) return {};
  const float eta = wo.z > 0 ? lobe.ior : 1 / lobe.ior;
  const Vec3 up{wo.x, wo.y, std::abs(wo.z)};
  Vec3 wi;
  bool refracted = false;
  if (u_part < lobe.multiple_share) {
    refracted = u_part >= lobe.multiple_share * lobe.multiple.b;
    wi = square_to_cosine_hemisphere(u);
    if (refracted) wi.z = -wi.z;
  } else {
    const float part = (u_part - lobe.multiple_share) / (1 - lobe.multiple_share);
    const Vec3 m = ggx::sample_visible_normal({lobe.alpha_x, lobe.alpha_y}, up, u);
    const float c = std::min(dot(up, m), 1.0F);
    const Fresnel fresnel = fresnel_dielectric(c, eta);
    refracted = part >= reflected_share(lobe, fresnel.reflectance);
    wi = normalize(refracted ? m * (c / eta - fresnel.cos_transmitted) - up / eta
                             : m * (2 * c) - up);
    if (refracted ? !(wi.z < 0) : !(wi.z > 0)) return {};
  }
  if (wo.z < 0) wi.z = -wi.z;
  const Scattering at = scattering(lobe, wo, wi);
  if (!(at.pdf > 0)) return {};
  return {.wi = wi,
          .weight = at.value / at.pdf,
          .pdf = at.pdf,
          .eta = refracted ? eta : 1,
          .transmission = refracted};
}

}  // namespace tessera::render::rough_dielectric
