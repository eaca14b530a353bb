#include "worker/render/bsdf/bsdf.hpp"

#include <algorithm>

#include "worker/render/bsdf/dielectric.hpp"
#include "worker/render/bsdf/diffuse.hpp"
#include "worker/render/bsdf/eon.hpp"
#include "worker/render/bsdf/microfacet.hpp"
#include "worker/render/bsdf/mirror.hpp"
#include "worker/render/bsdf/pane.hpp"
#include "worker/render/bsdf/rough_dielectric.hpp"

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
    case LobeKind::eon:
      return eon::sample(lobe, wo, u);
    case LobeKind::microfacet:
    case LobeKind::microfacet_through:
      return microfacet::sample(lobe, wo, u_lobe, u);
    case LobeKind::rough_dielectric:
      return rough_dielectric::sample(lobe, wo, u_lobe, u);
    case LobeKind::pane:
      return pane::sample(lobe, wo, u_lobe);
  }
  return {};
}

Scattering scattering_lobe(const Lobe& lobe, const Vec3& wo, const Vec3& wi) {
  switch (lobe.kind) {
    case LobeKind::diffuse:
      return {.value = diffuse::eval(lobe, wo, wi), .pdf = diffuse::pdf(wo, wi)};
    case LobeKind::eon:
      return {.value = eon::eval(lobe, wo, wi), .pdf = eon::pdf(wo, wi)};
    case LobeKind::microfacet:
    case LobeKind::microfacet_through:
      return microfacet::scattering(lobe, wo, wi);
    case LobeKind::rough_dielectric:
      return rough_dielectric::scattering(lobe, wo, wi);
    case LobeKind::mirror:
    case LobeKind::dielectric:
    case LobeKind::pane:
      break;
  }
  return {};
}

/// Of lobes that are weighed together with others: the weight and pdf of what is drawn may be any
/// above 0.
LobeSample draw_lobe(const Lobe& lobe, const Vec3& wo, float u_lobe, Vec2 u) {
  if (lobe.kind != LobeKind::microfacet && lobe.kind != LobeKind::microfacet_through)
    return sample_lobe(lobe, wo, u_lobe, u);
  const Vec3 wi = microfacet::draw(lobe, wo, u_lobe, u);
  if (wi.z == 0) return {};
  return {.wi = wi,
          .weight = gray(1),
          .pdf = 1,
          .transmission = lobe.kind == LobeKind::microfacet_through};
}

/// A pair of directions, in the world and in the shading frame.
struct Pair {
  const Vec3& world_wo;
  const Vec3& world_wi;
  Vec3 wo, wi;
  bool across;  ///< they are on different sides of the surface

  Pair(const Closure& closure, const Vec3& out, const Vec3& in)
      : world_wo(out),
        world_wi(in),
        wo(closure.shading.to_local(out)),
        wi(closure.shading.to_local(in)),
        across(!on_one_side(closure, out, in)) {}
  /// What a bent normal calls reflection must not pass through the true surface, nor the other way
  /// round (Veach 1997, section 5.3).
  [[nodiscard]] bool agrees() const { return across == (wo.z * wi.z <= 0); }
};

/// The same for lobes that have a frame of their own, each by its own; the others by the shading
/// frame.
struct Framed {
  Vec3 wo, wi;
  bool agrees;
  Framed(const Closure& closure, const Lobe& lobe, const Pair& at)
      : wo(at.wo), wi(at.wi), agrees(at.agrees()) {
    if (lobe.frame == 0) return;
    const Frame& frame = closure.frames[lobe.frame - std::size_t{1}];
    wo = frame.to_local(at.world_wo);
    wi = frame.to_local(at.world_wi);
    agrees = at.across == (wo.z * wi.z <= 0);
  }
};

[[gnu::noinline]] Scattering scattering_framed(const Closure& closure, const Pair& at) {
  Scattering sum;
  for (std::size_t i = 0; i < index_of(closure.count); ++i) {
    const Lobe& lobe = closure.lobes[i];
    const Framed in(closure, lobe, at);
    if (!in.agrees) continue;
    const Scattering one = scattering_lobe(lobe, in.wo, in.wi);
    sum.value += one.value;
    sum.pdf += closure.pick[i] * one.pdf;
  }
  sum.pdf /= closure.pick_sum;
  return sum;
}

Scattering scattering_of(const Closure& closure, const Pair& at) {
  if (closure.frame_count > 0) return scattering_framed(closure, at);
  if (!at.agrees()) return {};
  if (closure.count == 1) return scattering_lobe(closure.lobes[0], at.wo, at.wi);
  Scattering sum;
  for (std::size_t i = 0; i < index_of(closure.count); ++i) {
    const Scattering one = scattering_lobe(closure.lobes[i], at.wo, at.wi);
    sum.value += one.value;
    sum.pdf += closure.pick[i] * one.pdf;
  }
  if (closure.count > 0) sum.pdf /= closure.pick_sum;
  return sum;
}

const Frame& frame_of(const Closure& closure, const Lobe& lobe) {
  return lobe.frame == 0 ? closure.shading : closure.frames[lobe.frame - std::size_t{1}];
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
  const Frame& frame = frame_of(closure, lobe);
  const bool alone = closure.count == 1;
  const LobeSample drawn = alone ? sample_lobe(lobe, frame.to_local(wo), choice.u, u)
                                 : draw_lobe(lobe, frame.to_local(wo), choice.u, u);
  if (!(drawn.pdf > 0)) return {.kind = lobe.kind, .specular = !is_smooth(lobe)};

  BsdfSample result{.wi = frame.to_world(drawn.wi),
                    .weight = drawn.weight,
                    .pdf = drawn.pdf,
                    .kind = lobe.kind,
                    .specular = !is_smooth(lobe),
                    .transmission = drawn.transmission,
                    .eta = drawn.eta};
  if (on_one_side(closure, wo, result.wi) == drawn.transmission) {
    return {.kind = lobe.kind, .specular = !is_smooth(lobe)};
  }
  if (!alone) {
    if (result.specular) {
      result.pdf *= choice.probability;
      result.weight = drawn.weight / choice.probability;
    } else {
      const Scattering all = scattering_of(closure, Pair(closure, wo, result.wi));
      if (!(all.pdf > 0)) return {.kind = lobe.kind};
      result.pdf = all.pdf;
      result.weight = all.value / all.pdf;
    }
  }
  return result;
}

Scattering scattering(const Closure& closure, const Vec3& wo, const Vec3& wi) {
  const Lobe& first = closure.lobes[0];
  if (closure.count == 1 && first.kind == LobeKind::diffuse && first.frame == 0) {
    // Most surfaces by far: without the loops.
    const float cos_o = dot(wo, closure.shading.n), cos_i = dot(wi, closure.shading.n);
    if (!(cos_o * cos_i > 0) || !on_one_side(closure, wo, wi)) return {};
    const float density = inv_pi * std::abs(cos_i);
    return {.value = first.weight * density, .pdf = density};
  }
  return scattering_of(closure, Pair(closure, wo, wi));
}

Lobe scaled(const Lobe& lobe, const Color& by) {
  Lobe out = lobe;
  // An eon lobe is not linear in its albedo; later bounces in a rough dielectric are multiplied by
  // weight and tint anyhow.
  if (lobe.kind != LobeKind::eon) out.weight *= by;
  out.tint *= by;
  out.dip *= by;
  if (lobe.kind != LobeKind::rough_dielectric) out.multiple *= by;
  return out;
}

void scale(Closure& closure, int first, float by) {
  for (std::size_t i = index_of(first); i < index_of(closure.count); ++i) {
    closure.lobes[i] = scaled(closure.lobes[i], gray(by));
    closure.pick[i] *= by;
  }
  if (!(by > 0)) closure.count = std::min(closure.count, first);
  // Summed anew, so that what is left out leaves nothing behind.
  closure.pick_sum = 0;
  closure.flags = 0;
  closure.has_smooth = false;
  for (std::size_t i = 0; i < index_of(closure.count); ++i) {
    const std::uint8_t bits = lobe_flags(closure.lobes[i].kind);
    closure.pick_sum += closure.pick[i];
    closure.flags = static_cast<std::uint8_t>(closure.flags | bits);
    closure.has_smooth = closure.has_smooth || is_smooth(closure.lobes[i]);
  }
}

Color albedo(const Closure& closure) {
  Color sum;
  for (int i = 0; i < closure.count; ++i) {
    const Lobe& lobe = closure.lobes[index_of(i)];
    switch (lobe.kind) {
      case LobeKind::dielectric:
      case LobeKind::rough_dielectric:
      case LobeKind::pane:
        sum += gray(std::max(max_component(lobe.weight), max_component(lobe.tint)));
        break;
      case LobeKind::mirror:
        sum += is_black(lobe.tint) ? lobe.weight : lobe.tint;
        break;
      case LobeKind::eon:
        sum += lobe.weight * lobe.tint;
        break;
      default:
        sum += lobe.weight;
    }
  }
  return {std::clamp(sum.r, 0.0F, 1.0F), std::clamp(sum.g, 0.0F, 1.0F),
          std::clamp(sum.b, 0.0F, 1.0F)};
}

}  // namespace tessera::render
