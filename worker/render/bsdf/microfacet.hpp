#pragma once
#include "worker/render/bsdf/brushed_energy.hpp"
#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/bsdf/fresnel.hpp"
#include "worker/render/bsdf/ggx.hpp"
#include "worker/render/bsdf/lobe_sample.hpp"

/// Reflection by GGX's microfacets, on whichever side wo is, with the light that bounces between
/// them more than once as a second, diffuse part (Kulla and Conty 2017), so that nothing is lost
/// and the lobe stays reciprocal. Its twin throws the same light to the other side of a thin wall.
namespace tessera::render::microfacet {

struct Parameters {
  Reflectance reflectance;
  ggx::Roughness roughness;
  energy::Slant wo;  ///< in the lobe's frame
};
/// The rough lobe, or where α is too small for one a mirror; `through` is the twin, whose
/// reflectance is a mere colour.
Lobe lobe_of(const Parameters& parameters, bool through = false);
/// What such a lobe makes of light to wo: its directional albedo, but for a metal's dip.
Color albedo(const Parameters& parameters);

Color eval(const Lobe& lobe, const Vec3& wo, const Vec3& wi);
float pdf(const Lobe& lobe, const Vec3& wo, const Vec3& wi);
LobeSample sample(const Lobe& lobe, const Vec3& wo, float u_part, Vec2 u);

}  // namespace tessera::render::microfacet
