#include "worker/render/integrators/path.hpp"

#include "worker/render/integrators/found_light.hpp"
#include "worker/render/integrators/found_weight.hpp"
#include "worker/render/integrators/holes.hpp"
#include "worker/render/integrators/passing.hpp"
#include "worker/render/integrators/path_steps.hpp"

namespace tessera::render {
namespace {

/// `first_draw` is the light set's draw 0 of light_samples.
void add_direct(Trace& trace, const Sampler& sampler, const Draw4& first_draw,
                const PathState& path, const Interaction& at, SampleRecord& record) {
  const Closure& closure = trace.closure;
  const LightContext& context = path.last_context;
  const auto count = static_cast<std::uint32_t>(trace.light_samples);
  const float counted = static_cast<float>(count);
  const Scene& scene = trace.scene;
  for (std::uint32_t j = 0; j < count; ++j) {
    const Draw4 draw =
        j == 0 ? first_draw
               : sampler.draw4(dim::light_set(static_cast<std::uint32_t>(path.depth)), j, count);
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

/// The next hit. Its face is already on its way into the caches.
accel::Hit intersect(const Scene& scene, const Ray& ray, accel::Mask mask) {
  const accel::Hit hit = scene.intersect(ray, mask);
  if (hit.any()) prefetch_face(scene.geometry_of(hit), hit.primitive);
  return hit;
}
/// The same for a ray that sets out.
accel::Hit trace_ray(Trace& trace, const Ray& ray, accel::Mask mask) {
  ++trace.rays;
  return intersect(trace.scene, ray, mask);
}

}  // namespace

// The other integrators share its steps, so the compiler would call them one by one; in line they
// keep their values in registers.
[[gnu::flatten]] void path(Trace& trace, const Sampler& sampler, const Ray& ray,
                           SampleRecord& record) {
  const Scene& scene = trace.scene;
  Closure& closure = trace.closure;
  const bool lit = !scene.lights.empty();
  const auto light_samples = static_cast<std::uint32_t>(trace.light_samples);
  PathState path;
  path.ray = ray;
  const FoundWeight weight{trace, path};
  accel::Hit hit = trace_ray(trace, path.ray, ray_mask::camera);
  for (;;) {
    if (!hit.any()) return see_far(trace, path, weight, record);
    // A large scene's face is not in the caches, and its corners come after its indices: the random
    // numbers are made while memory answers.
    const auto depth = static_cast<std::uint32_t>(path.depth);
    const Draw4 draw = sampler.draw4(dim::bsdf_set(depth));
    prefetch_corners(scene.geometry_of(hit), hit.primitive);
    const Draw4 light_draw = sampler.draw4(dim::light_set(depth), 0, light_samples);

    Interaction at = surface_at(scene, path.ray, hit);
    const CompiledMaterial& material = scene.materials[at.material];
    if (path.media.size() > 0) absorb(trace, path, at.t);
    if (material.may_pass && passes(trace, sampler, path, at)) {
      if (path.passes == passes_most) return;
      hit = intersect(scene, path.ray, mask_of(path));
      continue;
    }
    evaluate(material, scene.textures, at.shading, closure);
    if (path.undescribed) {
      if (is_hole(trace, sampler, path, at, record)) return;
      describe(trace, hit, at, path, record);
    }
    see_emission(trace, path, at, weight, record);
    if (path.depth > trace.bounces || closure.count == 0) return;

    path.last_context = light_context(at, closure, path);
    const PathState here = path;
    const BsdfSample drawn = sample(closure, at.shading.wo, draw[dim::lobe], draw.pair(dim::bsdf));
    const bool goes_on = drawn && advance(trace, path, at, drawn, draw[dim::roulette]);
    // The path's next hit comes before the light of this one, so that light is sampled and its
    // shadow ray traced while memory brings the next face.
    if (goes_on) hit = trace_ray(trace, path.ray, ray_mask::indirect);
    if (closure.has_smooth && lit) add_direct(trace, sampler, light_draw, here, at, record);
    if (!goes_on) return;
    if (is_lit_apart(trace, path)) add_found_light(trace, path, weight, record);
  }
}

}  // namespace tessera::render
