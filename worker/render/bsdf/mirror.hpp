#pragma once
#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/bsdf/lobe_sample.hpp"

/// Perfect reflection, a delta, on both sides. eval and pdf of a delta are 0 everywhere, so there
/// are none here.
namespace tessera::render::mirror {

inline LobeSample sample(const Lobe& lobe, const Vec3& wo) {
  return {.wi = {-wo.x, -wo.y, wo.z}, .weight = lobe.weight, .pdf = 1};
}

}  // namespace tessera::render::mirror
