#pragma once
#include "worker/render/integrators/found_light.hpp"
#include "worker/render/integrators/holes.hpp"
#include "worker/render/integrators/passing.hpp"
#include "worker/render/integrators/path_steps.hpp"

namespace tessera::render {

/// The loop of the integrators that weigh no two strategies against each other. What differs
/// between them is in Rules, all static:
/// - BsdfSample draw(closure, wo, numbers): where a path goes on; `numbers` is the BSDF's set.
/// - void add_direct(trace, sampler, path, at, closure, record): light samples at a hit that has a
///   lobe other than deltas, or nothing. path.last_context is the hit's.
/// - bool counts(trace, path, light): whether emission that the path ran into is counted; `light`
///   is which of the scene's lights it is.
/// - bool roulette: whether paths of little throughput may be ended.
/// Depths, channels and rays are counted as path() does.
template <class Rules>
void walk(Trace& trace, CameraSample& taken) {
  const Scene& scene = trace.scene;
  const Sampler& sampler = taken.sampler;
  SampleRecord& record = taken.record;
  Closure& closure = trace.closures[0];
  PathState path;
  path.ray = taken.ray;
  const auto weight = [&](std::uint32_t light, const LightHit& /*hit*/) {
    return Rules::counts(trace, path, light) ? 1.0F : 0.0F;
  };
  ++trace.rays;
  for (;;) {
    const accel::Hit hit = scene.intersect(path.ray, mask_of(path));
    if (!hit.any()) return see_far(trace, path, weight, record);
    Interaction at = surface_at(scene, path.ray, hit);
    const CompiledMaterial& material = scene.materials[at.material];
    if (path.media.size() > 0) absorb(trace, path, at.t);
    if (material.may_pass && passes(trace, sampler, path, at)) {
      if (path.passes == passes_most) return;
      continue;
    }
    evaluate(material, scene.textures, at.shading, closure);
    if (path.undescribed) {
      if (is_hole(trace, sampler, path, at, closure, record)) return;
      describe(trace, hit, at, closure, path, record);
    }
    see_emission(trace, path, at, closure, weight, record);
    if (path.depth > trace.bounces || closure.count == 0) return;

    path.last_context = light_context(at, closure, path);
    if (closure.has_smooth) Rules::add_direct(trace, sampler, path, at, closure, record);
    const Draw4 draw = sampler.draw4(dim::bsdf_set(static_cast<std::uint32_t>(path.depth)));
    const BsdfSample drawn = Rules::draw(closure, at.shading.wo, draw);
    if (!drawn) return;
    scatter(trace, path, at, closure, drawn);
    if (Rules::roulette && !survives(path, draw[dim::roulette])) return;
    if (!set_out(trace, path, at, closure, drawn)) return;
    ++trace.rays;
    if (is_lit_apart(trace, path)) add_found_light(trace, path, weight, record);
  }
}

/// One sample after the other.
template <class Rules>
void walk(Trace& trace, std::span<CameraSample> samples) {
  for (CameraSample& taken : samples) walk<Rules>(trace, taken);
}

}  // namespace tessera::render
