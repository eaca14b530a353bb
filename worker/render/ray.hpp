#pragma once
#include <limits>

#include "worker/render/vec.hpp"

namespace tessera::render {

/// Half-open piece of a line, (t_min, t_max). The direction is of unit length, so t is a distance.
struct Ray {
  Vec3 origin;
  Vec3 direction{0, 0, 1};
  float t_min = 0;
  float t_max = std::numeric_limits<float>::infinity();
  float time = 0;        ///< within the shutter, 0…1
  float cone_width = 0;  ///< of the footprint at the origin
  float cone_spread =
      0;  ///< growth of that width per unit of distance (Akenine-Möller et al. 2019, ray cones)

  [[nodiscard]] Vec3 at(float t) const { return origin + direction * t; }
};

}  // namespace tessera::render
