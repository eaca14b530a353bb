#pragma once
#include "worker/render/integrators/integrator.hpp"
#include "worker/render/integrators/path_state.hpp"

/// How two ways of finding light are weighed against each other.
namespace tessera::render {

/// Weight of the strategy with density a against b (Veach's power heuristic, exponent 2). a > 0.
inline float power_heuristic(float a, float b) {
  const float ratio = b / a;
  return 1 / (1 + ratio * ratio);
}

/// Weight of light that a BSDF's sample found, against the light samples that were taken where the
/// path last scattered.
struct FoundWeight {
  const Trace& trace;
  const PathState& path;

  float operator()(std::uint32_t light, const LightHit& hit) const {
    if (path.last_specular || light == no_id) return 1;
    const float by_light = trace.scene.lights.pdf(path.last_context, light, hit);
    return power_heuristic(path.last_pdf, by_light * static_cast<float>(trace.light_samples));
  }
};

}  // namespace tessera::render
