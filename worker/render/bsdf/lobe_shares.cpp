#include "worker/render/bsdf/lobe_shares.hpp"

namespace tessera::render {

namespace {

/// 0…1, whatever the two are.
float share_of(float part, float whole) {
  if (!(whole > 0) || !(part > 0)) return 0;
  return part < whole ? part / whole : 1;
}

/// The diffuse lobes alone: for eval(), nothing else fits.
Closure diffuse_part(const Closure& closure) {
  Closure part = closure;
  std::size_t count = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(closure.count); ++i) {
    const LobeKind kind = closure.lobes[i].kind;
    if (kind == LobeKind::diffuse || kind == LobeKind::eon) part.lobes[count++] = closure.lobes[i];
  }
  part.count = static_cast<int>(count);
  return part;
}

}  // namespace

LobeShares lobe_shares(const Closure& closure, const Vec3& wo, const Vec3& wi) {
  if (!on_one_side(closure, wo, wi))
    return {.diffuse = {}, .specular = {}, .transmission = gray(1)};
  const Closure part = diffuse_part(closure);
  if (part.count == closure.count) return {.diffuse = gray(1), .specular = {}, .transmission = {}};
  const Color all = eval(closure, wo, wi);
  const Color some = part.count > 0 ? eval(part, wo, wi) : Color{};
  const Color diffuse{share_of(some.r, all.r), share_of(some.g, all.g), share_of(some.b, all.b)};
  return {.diffuse = diffuse,
          .specular = {1 - diffuse.r, 1 - diffuse.g, 1 - diffuse.b},
          .transmission = {}};
}

LobeShares lobe_shares(const Closure& closure, const Vec3& wo, const BsdfSample& drawn) {
  if (!drawn.specular) return lobe_shares(closure, wo, drawn.wi);
  if (drawn.transmission) return {.diffuse = {}, .specular = {}, .transmission = gray(1)};
  return {.diffuse = {}, .specular = gray(1), .transmission = {}};
}

}  // namespace tessera::render
