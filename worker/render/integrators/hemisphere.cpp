#include "worker/render/integrators/hemisphere.hpp"

#include "worker/render/integrators/hemisphere_rules.hpp"
#include "worker/render/warp.hpp"

namespace tessera::render {
namespace {

bool is_delta(const Lobe& lobe) { return (lobe_flags(lobe.kind) & lobe_flag::specular) != 0; }

/// The probability with which sample() takes a lobe that is not a delta.
float smooth_share(const Closure& closure) {
  float smooth = 0;
  for (int i = 0; i < closure.count; ++i) {
    const auto lobe = static_cast<std::size_t>(i);
    if (!is_delta(closure.lobes[lobe])) smooth += closure.pick[lobe];
  }
  return smooth / closure.pick_sum;
}

/// True if some lobe that is not a delta sends light to the other side.
bool passes_smoothly(const Closure& closure) {
  if ((closure.flags & lobe_flag::transmission) == 0) return false;
  for (int i = 0; i < closure.count; ++i) {
    const Lobe& lobe = closure.lobes[static_cast<std::size_t>(i)];
    if (!is_delta(lobe) && (lobe_flags(lobe.kind) & lobe_flag::transmission) != 0) return true;
  }
  return false;
}

}  // namespace

BsdfSample sample_hemisphere(const Closure& closure, const Vec3& wo, const Draw4& numbers) {
  float share = 1;
  if ((closure.flags & lobe_flag::specular) != 0) {
    const BsdfSample own = sample(closure, wo, numbers[dim::lobe], numbers.pair(dim::bsdf));
    if (own.specular) return own;
    share = smooth_share(closure);
  }
  Vec3 local = square_to_hemisphere(numbers.pair(dim::bsdf));
  float density = share * hemisphere_pdf(local);
  if (dot(wo, closure.shading.n) < 0) local.z = -local.z;
  bool transmission = false;
  if (passes_smoothly(closure)) {
    // Either side; there is no roulette here whose number would be needed.
    density *= 0.5F;
    transmission = numbers[dim::roulette] < 0.5F;
    if (transmission) local.z = -local.z;
  }
  const Vec3 wi = closure.shading.to_world(local);
  if (!(density > 0)) return {};
  return {.wi = wi,
          .weight = scattering(closure, wo, wi).value / density,
          .pdf = density,
          .transmission = transmission};
}

void hemisphere(Trace& trace, std::span<CameraSample> samples) {
  walk<HemisphereRules>(trace, samples);
}

}  // namespace tessera::render
