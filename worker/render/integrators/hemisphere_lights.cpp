#include "worker/render/integrators/hemisphere_lights.hpp"

#include "worker/render/integrators/hemisphere_rules.hpp"
#include "worker/render/lights/by_area.hpp"

namespace tessera::render {
namespace {

/// One light, and a point on it. The pdf holds the choice.
LightSample sample_lights_by_area(const LightTable& lights, const LightContext& context,
                                  const Draw4& draw) {
  const LightTable::Pick chosen = lights.pick(context, draw.bits(dim::light_pick));
  if (!(chosen.pmf > 0)) return {};
  LightSample light = sample_by_area(lights[chosen.light], context, draw.pair(dim::light));
  light.pdf *= chosen.pmf;
  light.light = chosen.light;
  return light;
}

struct HemisphereLightsRules : HemisphereRules {
  static void add_direct(Trace& trace, const Sampler& sampler, const PathState& path,
                         const Interaction& at, const Closure& closure, SampleRecord& record) {
    const LightTable& lights = trace.scene.lights;
    const std::uint32_t set = dim::light_set(static_cast<std::uint32_t>(path.depth));
    const auto count = static_cast<std::uint32_t>(trace.light_samples);
    for (std::uint32_t j = 0; j < count; ++j) {
      const Draw4 draw = sampler.draw4(set, j, count);
      const LightSample light = sample_lights_by_area(lights, path.last_context, draw);
      if (!light || is_black(light.radiance)) continue;
      const Color scattered = eval(closure, at.shading.wo, light.wi);
      if (is_black(scattered)) continue;
      const Color arriving = light_from(trace, at, closure, light, path);
      if (is_black(arriving)) continue;
      const float weight = 1 / (light.pdf * static_cast<float>(count));
      add_lit(trace, path, at, closure, light, path.throughput * scattered * arriving * weight,
              record);
    }
  }
  /// A light that is never chosen where the path last scattered is left to scattered rays.
  static bool counts(const Trace& trace, const PathState& path, std::uint32_t light) {
    return path.last_specular || light == no_id ||
           !(trace.scene.lights.pmf(path.last_context, light) > 0);
  }
};

}  // namespace

void hemisphere_lights(Trace& trace, std::span<CameraSample> samples) {
  walk<HemisphereLightsRules>(trace, samples);
}

}  // namespace tessera::render
