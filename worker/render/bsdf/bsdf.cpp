#include "worker/render/bsdf/bsdf.hpp"

#include <algorithm>
#include <array>
#include <cassert>

#include "worker/render/bsdf/bsdf_batch.hpp"
#include "worker/render/bsdf/lobe_calls.hpp"

namespace tessera::render {

namespace {

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

/// Sums up what a closure's lobes scatter, one after the other.
Scattering sum_of(const Closure& closure, const Scattering* parts) {
  if (closure.count == 1) return parts[0];
  Scattering sum;
  for (std::size_t i = 0; i < index_of(closure.count); ++i) {
    sum.value += parts[i].value;
    sum.pdf += closure.pick[i] * parts[i].pdf;
  }
  if (closure.count > 0) sum.pdf /= closure.pick_sum;
  return sum;
}

Scattering scattering_of(const Closure& closure, const Pair& at) {
  if (closure.frame_count > 0) return scattering_framed(closure, at);
  if (!at.agrees()) return {};
  std::array<Scattering, Closure::lobes_max> parts;
  for (std::size_t i = 0; i < index_of(closure.count); ++i)
    parts[i] = scattering_lobe(closure.lobes[i], at.wo, at.wi);
  return sum_of(closure, parts.data());
}

/// Most surfaces by far: diffuse alone, without the loops.
bool is_plain(const Closure& closure) {
  const Lobe& first = closure.lobes[0];
  return closure.count == 1 && first.kind == LobeKind::diffuse && first.frame == 0;
}
Scattering plain_scattering(const Closure& closure, const Vec3& wo, const Vec3& wi) {
  const float cos_o = dot(wo, closure.shading.n), cos_i = dot(wi, closure.shading.n);
  if (!(cos_o * cos_i > 0) || !on_one_side(closure, wo, wi)) return {};
  const float density = inv_pi * std::abs(cos_i);
  return {.value = closure.lobes[0].weight * density, .pdf = density};
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

/// How the value and density of a direction that is drawn are to be found.
struct Weighing {
  enum class By : std::uint8_t {
    nobody,  ///< a delta, or a lobe alone that weighs what it draws; or nothing was drawn
    lobe,    ///< a microfacet alone, by directions in its own frame
    all      ///< by all lobes, each in its frame
  };

  By by = By::nobody;
  const Lobe* lobe = nullptr;
  Vec3 wo, wi;  ///< in the lobe's frame
};

void weigh(const Scattering& all, BsdfSample& sample) {
  if (all.pdf > 0) {
    sample.pdf = all.pdf;
    sample.weight = all.value / all.pdf;
  } else {
    sample = {.kind = sample.kind};
  }
}

/// Writes all of `sample`, but for what is still to be weighed.
Weighing draw(const BsdfRequest& request, BsdfSample& sample) {
  const Closure& closure = *request.closure;
  sample = {};
  Weighing out;
  if (closure.count == 0) return out;
  const Choice choice = choose(closure, request.u_lobe);
  const Lobe& lobe = closure.lobes[index_of(choice.lobe)];
  const Frame& frame = frame_of(closure, lobe);
  sample.kind = lobe.kind;
  sample.specular = !is_smooth(lobe);
  out.lobe = &lobe;
  out.wo = frame.to_local(request.wo);
  const LobeSample drawn = draw_lobe(lobe, out.wo, choice.u, request.u);
  if (!(drawn.pdf > 0)) return out;
  out.wi = drawn.wi;
  const Vec3 wi = frame.to_world(drawn.wi);
  if (on_one_side(closure, request.wo, wi) == drawn.transmission) return out;

  sample.wi = wi;
  sample.weight = drawn.weight;
  sample.pdf = drawn.pdf;
  sample.transmission = drawn.transmission;
  sample.eta = drawn.eta;
  if (closure.count == 1) {
    if (is_microfacet(lobe)) out.by = Weighing::By::lobe;
  } else if (sample.specular) {
    sample.pdf *= choice.probability;
    sample.weight = drawn.weight / choice.probability;
  } else {
    out.by = Weighing::By::all;
  }
  return out;
}

}  // namespace

BsdfSample sample(const Closure& closure, const Vec3& wo, float u_lobe, Vec2 u) {
  BsdfSample out;
  const Weighing still = draw({&closure, wo, u_lobe, u}, out);
  if (still.by == Weighing::By::lobe)
    weigh(scattering_lobe(*still.lobe, still.wo, still.wi), out);
  else if (still.by == Weighing::By::all)
    weigh(scattering_of(closure, Pair(closure, wo, out.wi)), out);
  return out;
}

Scattering scattering(const Closure& closure, const Vec3& wo, const Vec3& wi) {
  if (is_plain(closure)) return plain_scattering(closure, wo, wi);
  return scattering_of(closure, Pair(closure, wo, wi));
}

void BsdfBatch::add(const ScatteringRequest& request, Scattering& out) {
  const Closure& closure = *request.closure;
  if (is_plain(closure)) {
    out = plain_scattering(closure, request.wo, request.wi);
    return;
  }
  const Pair at(closure, request.wo, request.wi);
  const auto lobes = index_of(closure.count);
  if (closure.frame_count > 0 || used_ + lobes > parts_.size()) {
    out = scattering_of(closure, at);
    return;
  }
  if (!at.agrees()) {
    out = {};
    return;
  }
  if (lobes == 1) {
    const Lobe& lobe = closure.lobes[0];
    if (is_microfacet(lobe)) {
      microfacets_.add(lobe, at.wo, at.wi, out);
    } else {
      out = scattering_lobe(lobe, at.wo, at.wi);
    }
    return;
  }
  sums_[count_++] = {&closure, &out, used_};
  for (std::size_t i = 0; i < lobes; ++i) {
    const Lobe& lobe = closure.lobes[i];
    Scattering& part = parts_[used_++];
    if (is_microfacet(lobe)) {
      microfacets_.add(lobe, at.wo, at.wi, part);
    } else {
      part = scattering_lobe(lobe, at.wo, at.wi);
    }
  }
}

void BsdfBatch::answer() {
  microfacets_.answer();
  for (std::size_t i = 0; i < count_; ++i)
    *sums_[i].out = sum_of(*sums_[i].closure, parts_.data() + sums_[i].first);
  count_ = used_ = 0;
}

void BsdfBatch::scattering(std::span<const ScatteringRequest> asked, std::span<Scattering> found) {
  assert(asked.size() <= samples_at_once && asked.size() <= found.size());
  for (std::size_t i = 0; i < asked.size(); ++i) add(asked[i], found[i]);
  answer();
}

void BsdfBatch::sample(std::span<const BsdfRequest> asked, std::span<BsdfSample> found) {
  assert(asked.size() <= samples_at_once && asked.size() <= found.size());
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const Weighing still = draw(asked[i], found[i]);
    if (still.by == Weighing::By::nobody) continue;
    if (still.by == Weighing::By::lobe)
      microfacets_.add(*still.lobe, still.wo, still.wi, weights_[i]);
    else
      add({asked[i].closure, asked[i].wo, found[i].wi}, weights_[i]);
    waiting_[waiting_count_++] = i;
  }
  answer();
  for (std::size_t k = 0; k < waiting_count_; ++k) weigh(weights_[waiting_[k]], found[waiting_[k]]);
  waiting_count_ = 0;
}

}  // namespace tessera::render
