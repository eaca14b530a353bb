#include <limits>

#include "worker/render/lights/shapes.hpp"

namespace tessera::render {

ShapeSample sample_shape(const DirectionalLight& light, bool /*two_sided*/,
                         const LightContext& /*context*/, Vec2 /*u*/) {
  return {.wi = -to_double(light.direction),
          .distance = std::numeric_limits<double>::infinity(),
          .pdf = 1};
}

}  // namespace tessera::render
