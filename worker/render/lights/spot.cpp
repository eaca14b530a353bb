#include <algorithm>
#include <cmath>

#include "worker/render/lights/shapes.hpp"

namespace tessera::render {

ShapeSample sample_shape(const SpotLight& spot, bool /*two_sided*/, const LightContext& context,
                         Vec2 /*u*/) {
  const Vec3d offset = to_double(spot.position) - to_double(context.p);
  const double square = length_squared(offset);
  if (!(square > 0)) return {};
  const double distance = std::sqrt(square);
  const Vec3d wi = offset / distance;
  const auto inner = static_cast<double>(spot.cos_inner);
  const auto outer = static_cast<double>(spot.cos_outer);
  const double cosine = -dot(wi, to_double(spot.axis));
  if (!(cosine > outer)) return {};
  const double part = cosine >= inner ? 1 : (cosine - outer) / (inner - outer);
  return {.wi = wi,
          .distance = distance,
          .pdf = 1,
          .share = gray(static_cast<float>(part * part / square))};
}

}  // namespace tessera::render
