#pragma once
#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/bsdf/lobe_sample.hpp"

/// Rough diffuse reflection that loses no light and is reciprocal: the EON model (Portsmouth, Kutz
/// and Hill, "EON: A Practical Energy-Preserving Rough Diffuse BRDF", JCGT 14(1), 2025), on
/// whichever side wo is. Roughness 0 is Lambert's lobe.
namespace tessera::render::eon {

/// With the cosine; black where wi and wo are on different sides.
Color eval(const Lobe& lobe, const Vec3& wo, const Vec3& wi);
float pdf(const Vec3& wo, const Vec3& wi);
LobeSample sample(const Lobe& lobe, const Vec3& wo, Vec2 u);

}  // namespace tessera::render::eon
