#pragma once
#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/bsdf/ggx.hpp"
#include "worker/render/bsdf/lobe_sample.hpp"

/// Reflection and refraction by the microfacets of an interface (Walter et al. 2007), with the
/// light that meets them more than once as a second, diffuse part on both sides (Kulla and Conty
/// 2017): nothing is lost, and both directions of a path agree. z points to the outer side. As
/// bsdf.hpp says, refracted radiance holds 1/η².
namespace tessera::render::rough_dielectric {

struct Parameters {
  Color reflectance = gray(1), transmittance = gray(1);
  float ior = 1;  ///< of the side away from the normal over that of the normal's side
  ggx::Roughness roughness;
  float cos_o = 1;  ///< of wo against the normal; negative on the inner side
};
/// The rough lobe, or the smooth one where α is too small or nothing is bent.
Lobe lobe_of(const Parameters& parameters);

/// As of a closure that has this lobe alone, in the lobe's frame.
Scattering scattering(const Lobe& lobe, const Vec3& wo, const Vec3& wi);
LobeSample sample(const Lobe& lobe, const Vec3& wo, float u_part, Vec2 u);

}  // namespace tessera::render::rough_dielectric
