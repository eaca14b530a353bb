#include "worker/render/bsdf/bsdf.hpp"

#include <algorithm>

#include "worker/render/bsdf/dielectric.hpp"
#include "worker/render/bsdf/diffuse.hpp"
#include "worker/render/bsdf/mirror.hpp"

namespace tessera::render {

namespace {

std::size_t index_of(int lobe) { return static_cast<std::size_t>(lobe); }

bool is_smooth(const Lobe& lobe) { return (lobe_flags(lobe.kind) & lobe_flag::specular) == 0; }

LobeSample sample_lobe(const Lobe& lobe, const Vec3& wo, float u_lobe, Vec2 u) {
  switch (lobe.kind) {
    case LobeKind::diffuse:
      return diffuse::sample(lobe, wo, u);
    case LobeKind::mirror:
      return mirror::sample(lobe, wo);
    case LobeKind::dielectric:
      return dielectric::sample(lobe, wo, u_lobe);
  }
  return {};
}

Color eval_lobe(const Lobe& lobe, const Vec3& wo, const Vec3& wi) {
  switch (lobe.kind) {
    case LobeKind::diffuse:
      return diffuse::eval(lobe, wo, wi);
    case LobeKind::mirror:
    case LobeKind::dielectric:
      break;
  }
  return {};
}

float pdf_lobe(const Lobe& lobe, const Vec3& wo, const Vec3& wi) {
  switch (lobe.kind) {
    case LobeKind::diffuse:
      return diffuse::pdf(wo, wi);
    case LobeKind::mirror:
    case LobeKind::dielectric:
      break;
  }
  return 0;
}

/// True if wo and wi agree about the side they are on by both normals: what a bent normal calls
/// reflection must not pass through the true surface, nor the other way round (Veach 1997,
/// section 5.3).
bool sides_agree(const Closure& closure, const Vec3& wo, const Vec3& wi, bool transmission) {
  const bool other_side = dot(wo, closure.normal) * dot(wi, closure.normal) <= 0;
  return other_side == transmission;
}

/// Sums over the smooth lobes, in the shading frame.
Color eval_local(const Closure& closure, const Vec3& wo, const Vec3& wi) {
  Color sum;
  for (int i = 0; i < closure.count; ++i) sum += eval_lobe(closure.lobes[index_of(i)], wo, wi);
  return sum;
}
float pdf_local(const Closure& closure, const Vec3& wo, const Vec3& wi) {
  if (closure.count == 1) return pdf_lobe(closure.lobes[0], wo, wi);
  float sum = 0;
  for (int i = 0; i < closure.count; ++i) {
    sum += closure.pick[index_of(i)] * pdf_lobe(closure.lobes[index_of(i)], wo, wi);
  }
  return closure.count > 0 ? sum / closure.pick_sum : 0;
}

struct Choice {
  int lobe = 0;
  float probability = 1;
  float u = 0;  ///< what is left of the number: uniform again, independent of the choice
};

Choice choose(const Closure& closure, float u) {
  if (closure.count == 1) return {.lobe = 0, .probability = 1, .u = u};
  float rest = u * closure.pick_sum;
  int lobe = 0;
  while (lobe + 1 < closure.count && rest >= closure.pick[index_of(lobe)]) {
    rest -= closure.pick[index_of(lobe)];
    ++lobe;
  }
  const float pick = closure.pick[index_of(lobe)];
  return {.lobe = lobe,
          .probability = pick / closure.pick_sum,
          .u = std::min(rest / pick, one_minus_epsilon)};
}

}  // namespace

BsdfSample sample(const Closure& closure, const Vec3& wo, float u_lobe, Vec2 u) {
  if (closure.count == 0) return {};
  const Choice choice = choose(closure, u_lobe);
  const Lobe& lobe = closure.lobes[index_of(choice.lobe)];
  const Vec3 local_wo = closure.shading.to_local(wo);
  const LobeSample drawn = sample_lobe(lobe, local_wo, choice.u, u);
  if (!(drawn.pdf > 0)) return {.kind = lobe.kind, .specular = !is_smooth(lobe)};

  BsdfSample result{.wi = closure.shading.to_world(drawn.wi),
                    .weight = drawn.weight,
                    .pdf = drawn.pdf,
                    .kind = lobe.kind,
                    .specular = !is_smooth(lobe),
                    .transmission = drawn.transmission,
                    .eta = drawn.eta};
  if (!sides_agree(closure, wo, result.wi, drawn.transmission)) {
    return {.kind = lobe.kind, .specular = !is_smooth(lobe)};
  }
  if (closure.count > 1) {
    if (result.specular) {
      result.pdf *= choice.probability;
      result.weight = drawn.weight / choice.probability;
    } else {
      result.pdf = pdf_local(closure, local_wo, drawn.wi);
      result.weight = eval_local(closure, local_wo, drawn.wi) / result.pdf;
    }
  }
  return result;
}

Scattering scattering(const Closure& closure, const Vec3& wo, const Vec3& wi) {
  const Vec3 local_wo = closure.shading.to_local(wo), local_wi = closure.shading.to_local(wi);
  if (!sides_agree(closure, wo, wi, local_wo.z * local_wi.z <= 0)) return {};
  return {.value = eval_local(closure, local_wo, local_wi),
          .pdf = pdf_local(closure, local_wo, local_wi)};
}

Color albedo(const Closure& closure) {
  Color sum;
  for (int i = 0; i < closure.count; ++i) {
    const Lobe& lobe = closure.lobes[index_of(i)];
    sum += lobe.kind == LobeKind::dielectric ? gray(1) : lobe.weight;
  }
  return {std::clamp(sum.r, 0.0F, 1.0F), std::clamp(sum.g, 0.0F, 1.0F),
          std::clamp(sum.b, 0.0F, 1.0F)};
}

}  // namespace tessera::render
