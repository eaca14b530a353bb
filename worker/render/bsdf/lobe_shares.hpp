#pragma once
#include "worker/render/bsdf/bsdf.hpp"

namespace tessera::render {

/// Which part of the light that a surface scattered did so in which way; they sum to 1.
struct LobeShares {
  Color diffuse, specular, transmission;
};

/// Of light from wi that eval() weighs: what goes through by the geometric normal is transmission,
/// what is reflected is split by the lobes' values.
LobeShares lobe_shares(const Closure& closure, const Vec3& wo, const Vec3& wi);
/// Of light from a direction that was drawn.
LobeShares lobe_shares(const Closure& closure, const Vec3& wo, const BsdfSample& drawn);

}  // namespace tessera::render
