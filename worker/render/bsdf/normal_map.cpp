#include "worker/render/bsdf/normal_map.hpp"

namespace tessera::render {

Vec3 keep_mirrored_outside(const Vec3& n, const Vec3& geometric, const Vec3& wo) {
  const float side = dot(wo, geometric) < 0 ? -1.0F : 1.0F;
  const Vec3 up = geometric * side, bent = n * side;
  constexpr float least = 0.01F;
  const Vec3 mirrored = bent * (2 * dot(bent, wo)) - wo;
  const float height = dot(mirrored, up);
  if (height >= least) return n;
  const Vec3 lifted = normalize(mirrored + up * (least - height));
  const Vec3 half = normalize(lifted + wo);
  return length_squared(half) > 0 ? half * side : geometric;
}

Frame NormalSlot::frame(const Source& source) const {
  const ShadingPoint& point = source.point;
  if (!point.detail) return point.shading;
  const Texel texel = source.textures.lookup(texture, point.detail);
  const Vec3 local{(2 * texel[0] - 1) * scale, (2 * texel[1] - 1) * scale, 2 * texel[2] - 1};
  const SurfaceDetail& detail = *point.detail;
  const Vec3 n =
      normalize(detail.tangent * local.x + detail.bitangent * local.y + point.shading.n * local.z);
  // What points into the surface is no normal of it.
  if (!(dot(n, point.normal) > 0)) return point.shading;
  return Frame(keep_mirrored_outside(n, point.normal, point.wo));
}

}  // namespace tessera::render
