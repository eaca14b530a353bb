#include <cmath>

#include "worker/render/lights/shapes.hpp"

namespace tessera::render {

ShapeSample sample_shape(const PointLight& point, bool /*two_sided*/, const LightContext& context,
                         Vec2 /*u*/) {
  const Vec3d offset = to_double(point.position) - to_double(context.p);
  const double square = length_squared(offset);
  if (!(square > 0)) return {};
  const double distance = std::sqrt(square);
  return {.wi = offset / distance,
          .distance = distance,
          .pdf = 1,
          .share = gray(static_cast<float>(1 / square))};
}

}  // namespace tessera::render
