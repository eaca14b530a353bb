#include "worker/render/integrators/holes.hpp"

#include "worker/render/integrators/found_light.hpp"
#include "worker/render/integrators/found_weight.hpp"
#include "worker/render/integrators/passing.hpp"

namespace tessera::render {
namespace {

bool catches(const Scene& scene, const Interaction& at) {
  return scene.visibility_of(at.placement, at.geometry).shadow_catcher;
}

/// The part of light that passes along a shadow ray by catchers, as if nothing else were there.
float passed_by_catchers(Trace& trace, Ray ray) {
  float passed = 1;
  ++trace.rays;
  for (int surfaces = 0; surfaces < passes_most; ++surfaces) {
    const accel::Hit hit = trace.scene.intersect(ray, ray_mask::shadow);
    if (!hit.any()) return passed;
    const Interaction at = surface_at(trace.scene, ray, hit);
    if (catches(trace.scene, at)) passed *= passing_share(trace.scene, at);
    ray.t_min = at.behind(ray);
    if (!(passed > 0) || !(ray.t_min < ray.t_max)) return passed;
  }
  return 0;
}

/// Lambert's lobe of albedo 1, whatever the surface is made of.
void make_white(const ShadingPoint& point, Closure& out) {
  out.clear();
  out.shading = point.shading;
  out.normal = point.normal;
  out.add({.kind = LobeKind::diffuse, .weight = gray(1)});
  out.rounded = point.rounded;
  out.round_normal = point.shading.n;
}

/// What a light's sample sends to `at` where nothing stands between, and the ray that leads there.
/// False if that is nothing. As in light_from(), which shares nothing with it so that path() stays
/// as fast as it is.
bool aim(const Trace& trace, const Interaction& at, const Closure& closure,
         const LightSample& light, const PathState& path, Ray& ray, Color& sent) {
  const Scene& scene = trace.scene;
  const float length = light.distance * (1 - shadow_margin) - scene.light_errors[light.light];
  if (!(length > 0)) return false;
  ray = at.leave(light.wi, length, path.ray);
  if (!leaves(trace, at, closure, ray)) return false;
  sent = scene.lights[light.light].varies ? radiance_at(scene, light, ray) : light.radiance;
  return true;
}

/// The light samples of path(), each with and without what is no catcher.
void add_sampled(Trace& trace, const Sampler& sampler, const PathState& path, const Interaction& at,
                 const Closure& closure, Caught& caught) {
  const Scene& scene = trace.scene;
  const auto count = static_cast<std::uint32_t>(trace.light_samples);
  for (std::uint32_t j = 0; j < count; ++j) {
    const Draw4 draw = sampler.draw4(dim::light_set(0), j, count);
    const LightSample light =
        scene.lights.sample(path.last_context, draw.bits(dim::light_pick), draw.pair(dim::light));
    if (!light || is_black(light.radiance)) continue;
    const Scattering scattered = scattering(closure, at.shading.wo, light.wi);
    if (is_black(scattered.value)) continue;
    Ray ray;
    Color sent;
    if (!aim(trace, at, closure, light, path, ray, sent)) continue;
    const float by_light = light.pdf * static_cast<float>(count);
    const float weight = light.delta ? 1 : power_heuristic(by_light, scattered.pdf);
    const Color brought = path.throughput * scattered.value * sent *
                          absorbed_along(scene, path.media, ray.t_max) * (weight / by_light);
    ++trace.rays;
    const Color passed = transmittance(scene, ray);
    caught.shadowed += brought * passed;
    caught.unshadowed += brought * (passed == gray(1) ? 1 : passed_by_catchers(trace, ray));
  }
}

/// What find_light() finds for a ray that left a catcher, with and without what is no catcher.
struct CaughtRules {
  const Trace& trace;
  FoundWeight weight;
  Caught& caught;
  /// The path's throughput is what catchers pass; this the part of it that all else does.
  float shadow = 1;

  void add(const Color& light) {
    caught.shadowed += light * shadow;
    caught.unshadowed += light;
  }
  void add_far(const PathState& along) {
    SampleRecord far;
    render::add_far(trace, along, weight, far);
    add(far.radiance);
  }
  void add_met(const PathState& along, const Interaction& at, const Color& sent) {
    add(along.throughput * sent * weight(at.light, light_hit(along, at)));
  }
  bool go_on(PathState& along, const Interaction& at, float share) {
    if (!catches(trace.scene, at)) {
      shadow *= share;
      return true;
    }
    along.throughput *= share;
    return share > 0;
  }
};

/// Direct light on a white surface by light samples and one of its own, weighed against each other:
/// light samples alone do not find all (LightTable), and this is what path() would have found.
void catch_light(Trace& trace, const Sampler& sampler, const PathState& path, const Interaction& at,
                 Closure& closure, Caught& caught) {
  make_white(at.shading, closure);
  PathState here = path;
  here.last_context = light_context(at, closure, path);
  if (!trace.scene.lights.empty()) add_sampled(trace, sampler, here, at, closure, caught);
  const Draw4 draw = sampler.draw4(dim::bsdf_set(0));
  const BsdfSample drawn = sample(closure, at.shading.wo, draw[dim::lobe], draw.pair(dim::bsdf));
  if (!drawn || !set_out(trace, here, at, closure, drawn)) return;
  here.throughput *= drawn.weight;
  here.last_pdf = drawn.pdf;
  here.last_specular = false;
  find_light(trace, here, CaughtRules{trace, {trace, here}, caught});
}

}  // namespace

bool look_into_hole(Trace& trace, const Sampler& sampler, const PathState& path,
                    const Interaction& at, Closure& closure, SampleRecord& record) {
  const scene::Visibility seen = trace.scene.visibility_of(at.placement, at.geometry);
  if (seen.shadow_catcher && record.extras != nullptr) {
    record.extras->caught.coverage = 1;
    catch_light(trace, sampler, path, at, closure, record.extras->caught);
  }
  return seen.holdout || seen.shadow_catcher;
}

}  // namespace tessera::render
