#pragma once
#include "worker/render/vec.hpp"

namespace tessera::render {

/// A direction drawn from one lobe, in the shading frame. See bsdf.hpp for where the cosine goes.
struct LobeSample {
  Vec3 wi;
  Color weight;   ///< f·|cos θi| / pdf
  float pdf = 0;  ///< per solid angle, or a delta's probability; 0: nothing was sampled
  float eta = 1;
  bool transmission = false;
};

}  // namespace tessera::render
