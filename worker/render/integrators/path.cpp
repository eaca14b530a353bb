#include "worker/render/integrators/path.hpp"

#include <array>
#include <cassert>
#include <optional>

#include "worker/render/integrators/found_light.hpp"
#include "worker/render/integrators/found_weight.hpp"
#include "worker/render/integrators/holes.hpp"
#include "worker/render/integrators/passing.hpp"
#include "worker/render/integrators/path_steps.hpp"

namespace tessera::render {
namespace {

void add_direct(Trace& trace, const Sampler& sampler, const PathState& path, const Interaction& at,
                SampleRecord& record) {
  const Closure& closure = trace.closure;
  const LightContext& context = path.last_context;
  const auto count = static_cast<std::uint32_t>(trace.light_samples);
  const float counted = static_cast<float>(count);
  const Scene& scene = trace.scene;
  for (std::uint32_t j = 0; j < count; ++j) {
    const Draw4 draw =
        sampler.draw4(dim::light_set(static_cast<std::uint32_t>(path.depth)), j, count);
    const LightSample light =
        scene.lights.sample(context, draw.bits(dim::light_pick), draw.pair(dim::light));
    if (!light || is_black(light.radiance)) continue;
    const Scattering scattered = scattering(closure, at.shading.wo, light.wi);
    if (is_black(scattered.value)) continue;
    const Color arriving = light_from(trace, at, light, path);
    if (is_black(arriving)) continue;
    const float by_light = light.pdf * counted;
    const float weight = light.delta ? 1 : power_heuristic(by_light, scattered.pdf);
    add_lit(trace, path, at, light,
            path.throughput * scattered.value * arriving * (weight / by_light), record);
  }
}

/// A path that is under way.
struct Lane {
  CameraSample& sample;
  PathState path;
  accel::Hit hit;

  explicit Lane(CameraSample& taken) : sample(taken) { path.ray = taken.ray; }
};

/// Follows a path over what it met. False if it ends there.
bool step(Trace& trace, Lane& lane) {
  const Scene& scene = trace.scene;
  const Sampler& sampler = lane.sample.sampler;
  SampleRecord& record = lane.sample.record;
  Closure& closure = trace.closure;
  PathState& path = lane.path;
  const FoundWeight weight{trace, path};
  if (!lane.hit.any()) {
    see_far(trace, path, weight, record);
    return false;
  }
  Interaction at = surface_at(scene, path.ray, lane.hit);
  const CompiledMaterial& material = scene.materials[at.material];
  if (path.media.size() > 0) absorb(trace, path, at.t);
  if (material.may_pass && passes(trace, sampler, path, at)) return path.passes != passes_most;
  evaluate(material, scene.textures, at.shading, closure);
  if (path.undescribed) {
    if (is_hole(trace, sampler, path, at, record)) return false;
    describe(trace, lane.hit, at, path, record);
  }
  see_emission(trace, path, at, weight, record);
  if (path.depth > trace.bounces || closure.count == 0) return false;

  path.last_context = light_context(at, closure, path);
  if (closure.has_smooth && !scene.lights.empty()) add_direct(trace, sampler, path, at, record);
  const Draw4 draw = sampler.draw4(dim::bsdf_set(static_cast<std::uint32_t>(path.depth)));
  const BsdfSample drawn = sample(closure, at.shading.wo, draw[dim::lobe], draw.pair(dim::bsdf));
  if (!drawn || !advance(trace, path, at, drawn, draw[dim::roulette])) return false;
  ++trace.rays;
  if (is_lit_apart(trace, path)) add_found_light(trace, path, weight, record);
  return true;
}

}  // namespace

// The other integrators share its steps, so the compiler would call them one by one; in line they
// keep their values in registers.
[[gnu::flatten]] void path(Trace& trace, std::span<CameraSample> samples) {
  assert(samples.size() <= samples_at_once);
  const Scene& scene = trace.scene;
  std::array<std::optional<Lane>, samples_at_once> lanes;
  std::array<Lane*, samples_at_once> going{};
  std::size_t count = 0;
  for (CameraSample& sample : samples) {
    going[count] = &lanes[count].emplace(sample);
    ++count;
  }
  trace.rays += static_cast<std::int64_t>(count);
  // All of them meet something before any of them looks at what it met. A large scene's faces are
  // not in the caches: they are asked for at once, and their corners when the indices are there.
  while (count > 0) {
    for (std::size_t i = 0; i < count; ++i) {
      Lane& lane = *going[i];
      lane.hit = scene.intersect(lane.path.ray, mask_of(lane.path));
      if (lane.hit.any()) prefetch_face(scene.geometry_of(lane.hit), lane.hit.primitive);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const accel::Hit& hit = going[i]->hit;
      if (hit.any()) prefetch_corners(scene.geometry_of(hit), hit.primitive);
    }
    std::size_t left = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (step(trace, *going[i])) going[left++] = going[i];
    }
    count = left;
  }
}

}  // namespace tessera::render
