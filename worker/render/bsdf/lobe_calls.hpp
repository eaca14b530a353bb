#pragma once
#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/bsdf/dielectric.hpp"
#include "worker/render/bsdf/diffuse.hpp"
#include "worker/render/bsdf/eon.hpp"
#include "worker/render/bsdf/microfacet.hpp"
#include "worker/render/bsdf/mirror.hpp"
#include "worker/render/bsdf/pane.hpp"
#include "worker/render/bsdf/rough_dielectric.hpp"

/// Each kind of lobe's own functions, by its kind.
namespace tessera::render {

inline std::size_t index_of(int lobe) { return static_cast<std::size_t>(lobe); }

inline bool is_smooth(const Lobe& lobe) {
  return (lobe_flags(lobe.kind) & lobe_flag::specular) == 0;
}

inline bool is_microfacet(const Lobe& lobe) {
  return lobe.kind == LobeKind::microfacet || lobe.kind == LobeKind::microfacet_through;
}

/// A direction and what it weighs; of a microfacet the direction alone, whose weight and pdf are 1
/// until scattering_lobe() tells.
inline LobeSample draw_lobe(const Lobe& lobe, const Vec3& wo, float u_lobe, Vec2 u) {
  switch (lobe.kind) {
    case LobeKind::diffuse:
      return diffuse::sample(lobe, wo, u);
    case LobeKind::mirror:
      return mirror::sample(lobe, wo);
    case LobeKind::dielectric:
      return dielectric::sample(lobe, wo, u_lobe);
    case LobeKind::eon:
      return eon::sample(lobe, wo, u);
    case LobeKind::microfacet:
    case LobeKind::microfacet_through: {
      const Vec3 wi = microfacet::draw(lobe, wo, u_lobe, u);
      if (wi.z == 0) return {};
      return {.wi = wi,
              .weight = gray(1),
              .pdf = 1,
              .transmission = lobe.kind == LobeKind::microfacet_through};
    }
    case LobeKind::rough_dielectric:
      return rough_dielectric::sample(lobe, wo, u_lobe, u);
    case LobeKind::pane:
      return pane::sample(lobe, wo, u_lobe);
  }
  return {};
}

inline Scattering scattering_lobe(const Lobe& lobe, const Vec3& wo, const Vec3& wi) {
  switch (lobe.kind) {
    case LobeKind::diffuse:
      return {.value = diffuse::eval(lobe, wo, wi), .pdf = diffuse::pdf(wo, wi)};
    case LobeKind::eon:
      return {.value = eon::eval(lobe, wo, wi), .pdf = eon::pdf(wo, wi)};
    case LobeKind::microfacet:
    case LobeKind::microfacet_through:
      return microfacet::scattering(lobe, wo, wi);
    case LobeKind::rough_dielectric:
      return rough_dielectric::scattering(lobe, wo, wi);
    case LobeKind::mirror:
    case LobeKind::dielectric:
    case LobeKind::pane:
      break;
  }
  return {};
}

}  // namespace tessera::render
