#include "worker/render/integrators/cosine.hpp"

#include "worker/render/integrators/walk.hpp"

namespace tessera::render {
namespace {

struct CosineRules {
  static BsdfSample draw(const Closure& closure, const Vec3& wo, const Draw4& numbers) {
    return sample(closure, wo, numbers[dim::lobe], numbers.pair(dim::bsdf));
  }
  static void add_direct(Trace& /*trace*/, const Sampler& /*sampler*/, const PathState& /*path*/,
                         const Interaction& /*at*/, const Closure& /*closure*/,
                         SampleRecord& /*record*/) {}
  static bool counts(const Trace& /*trace*/, const PathState& /*path*/, std::uint32_t /*light*/) {
    return true;
  }
  static constexpr bool roulette = true;
};

}  // namespace

void cosine(Trace& trace, std::span<CameraSample> samples) { walk<CosineRules>(trace, samples); }

}  // namespace tessera::render
