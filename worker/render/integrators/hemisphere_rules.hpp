#pragma once
#include "worker/render/integrators/walk.hpp"

namespace tessera::render {

/// A direction uniform over the hemisphere around the shading normal, on wo's side: density 1/2π,
/// weight 2π·f·cos θ; where a lobe that is no delta sends light to the other side, over the whole
/// sphere. Deltas, which no such direction meets, are followed as sample() follows them:
/// where a closure has both, the numbers choose between the lobes as they do there.
BsdfSample sample_hemisphere(const Closure& closure, const Vec3& wo, const Draw4& numbers);

/// Rules of walk() for the report's estimator.
struct HemisphereRules {
  static BsdfSample draw(const Closure& closure, const Vec3& wo, const Draw4& numbers) {
    return sample_hemisphere(closure, wo, numbers);
  }
  static void add_direct(Trace& /*trace*/, const Sampler& /*sampler*/, const PathState& /*path*/,
                         const Interaction& /*at*/, const Closure& /*closure*/,
                         SampleRecord& /*record*/) {}
  static bool counts(const Trace& /*trace*/, const PathState& /*path*/, std::uint32_t /*light*/) {
    return true;
  }
  static constexpr bool roulette = false;
};

}  // namespace tessera::render
