#include "worker/render/bsdf/normal_map.hpp"

#include <algorithm>
#include <cmath>

namespace tessera::render {

Vec3 turned_outside(const Vec3& n, const Vec3& geometric, const Vec3& wo) {
  const float side = dot(wo, geometric) < 0 ? -1.0F : 1.0F;
  const Vec3 up = geometric * side, bent = n * side;
  const float least = least_height(geometric, wo);
  const Vec3 mirrored = bent * (2 * dot(bent, wo)) - wo;
  const Vec3 lifted = normalize(mirrored + up * (least - dot(mirrored, up)));
  const Vec3 half = normalize(lifted + wo);
  return length_squared(half) > 0 ? half * side : geometric;
}

namespace {

bool can_bend(const ShadingPoint& point, const TextureUse& texture) {
  return point.detail && point.detail->has_tangents() && point.detail->has_uv(texture.uv_set);
}

/// The frame about `n`, as far as `shading` may be bent to it.
Frame bent_frame(const Vec3& n, const ShadingPoint& point, const Frame& shading) {
  // What points into the surface is no normal of it.
  if (!(dot(n, point.normal) > 0)) return shading;
  return Frame(keep_mirrored_outside(n, point.normal, point.wo));
}

Vec2 plus(Vec2 a, Vec2 b, float times) { return {a.x + b.x * times, a.y + b.y * times}; }

}  // namespace

Frame NormalSlot::frame(const Source& source) const {
  const ShadingPoint& point = source.point;
  if (!can_bend(point, texture)) return point.shading;
  const Texel texel = source.textures.lookup(texture, point.detail);
  const Vec3 local{(2 * texel[0] - 1) * scale, (2 * texel[1] - 1) * scale, 2 * texel[2] - 1};
  const SurfaceDetail& detail = *point.detail;
  const Vec3 n =
      normalize(detail.tangent * local.x + detail.bitangent * local.y + point.shading.n * local.z);
  return bent_frame(n, point, point.shading);
}

Frame BumpSlot::frame(const Source& source, const Frame& shading) const {
  const ShadingPoint& point = source.point;
  if (!can_bend(point, texture)) return shading;
  const SurfaceDetail& detail = *point.detail;
  const TexturePoint& at = detail.uv[texture.uv_set];
  const Vec2 texels = source.textures.texels(texture.texture);
  const std::array<float, 6>& m = texture.to_uv;
  // How the height grows per unit of length along a way on which coordinates grow by `by`.
  const auto slope = [&](Vec2 by) {
    const Vec2 moved{(m[0] * by.x + m[1] * by.y) * texels.x,
                     (m[3] * by.x + m[4] * by.y) * texels.y};
    const float per_length = std::sqrt(moved.x * moved.x + moved.y * moved.y);
    if (!(per_length > 0)) return 0.0F;
    const float half = std::max(0.5F / per_length, 0.5F * point.footprint);
    TexturePoint before = at, behind = at;
    before.uv = plus(at.uv, by, -half);
    behind.uv = plus(at.uv, by, half);
    const float rise =
        source.textures.lookup(texture, behind)[0] - source.textures.lookup(texture, before)[0];
    return rise * height / (2 * half);
  };
  const Frame axes = detail.tangents_about(shading.n);
  const Vec3 n =
      normalize(shading.n - axes.s * slope(at.by_tangent) - axes.t * slope(at.by_bitangent));
  return bent_frame(n, point, shading);
}

}  // namespace tessera::render
