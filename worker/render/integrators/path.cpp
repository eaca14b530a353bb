#include "worker/render/integrators/path.hpp"

#include <algorithm>

#include "worker/render/integrators/path_state.hpp"
#include "worker/render/interaction.hpp"

namespace tessera::render {
namespace {

/// From this depth on a path may be ended.
constexpr int roulette_from = 2;
/// A shadow ray ends this part of its length before the light.
constexpr float shadow_margin = 0x1p-13F;

/// Weight of the strategy with density a against b (Veach's power heuristic, exponent 2). a > 0.
float power_heuristic(float a, float b) {
  const float ratio = b / a;
  return 1 / (1 + ratio * ratio);
}

/// Weight of light that a BSDF's sample found, against the light samples that were taken where the
/// path last scattered.
float found_weight(const Trace& trace, const PathState& path, std::uint32_t light,
                   const LightHit& hit) {
  if (path.last_specular || light == no_id) return 1;
  const float by_light = trace.scene.lights.pdf(path.last_context, light, hit);
  return power_heuristic(path.last_pdf, by_light * static_cast<float>(trace.light_samples));
}

void add_environment(const Trace& trace, const PathState& path, SampleRecord& record) {
  const Scene& scene = trace.scene;
  if (path.depth == 0 && scene.has_environment) record.alpha = 1;
  const std::uint32_t light = scene.lights.environment();
  if (light == no_id) return;
  LightHit hit;
  hit.wi = path.ray.direction;
  const float weight = found_weight(trace, path, light, hit);
  const Light& environment = scene.lights[light];
  record.add(path.throughput * environment.radiance * weight, path.first_lobe, path.depth,
             environment.group);
}

void add_emission(const Trace& trace, const PathState& path, const Interaction& at,
                  const Color& emission, SampleRecord& record) {
  if (is_black(emission)) return;
  LightHit hit;
  hit.wi = path.ray.direction;
  hit.distance = at.t;
  hit.instance = at.instance;
  hit.primitive = at.primitive;
  const float weight = found_weight(trace, path, at.light, hit);
  const std::uint16_t group =
      at.light == no_id ? std::uint16_t{0} : trace.scene.lights[at.light].group;
  record.add(path.throughput * emission * weight, path.first_lobe, path.depth, group);
}

FirstLobe lobe_of(const BsdfSample& drawn) {
  if (drawn.transmission) return FirstLobe::transmission;
  return drawn.specular ? FirstLobe::specular : FirstLobe::diffuse;
}

/// Where light samples are taken from: the side of wo, unless light may come from both. That is
/// also where the ray to the light starts, so that a light which scatters too finds its own points
/// on the right side of itself.
LightContext light_context(const Interaction& at, const Closure& closure, const PathState& path) {
  LightContext context;
  context.p = at.p;
  context.medium = path.media.innermost();
  if ((closure.flags & lobe_flag::transmission) == 0) {
    const Vec3& n = closure.shading.n;
    context.n = dot(n, at.shading.wo) < 0 ? -n : n;
    context.p = at.start(at.shading.wo);
  }
  return context;
}

/// `first_draw` is the light set's draw 0 of light_samples.
void add_direct(Trace& trace, const Sampler& sampler, const Draw4& first_draw,
                const PathState& path, const Interaction& at, SampleRecord& record) {
  const Closure& closure = trace.closure;
  const LightContext& context = path.last_context;
  const auto count = static_cast<std::uint32_t>(trace.light_samples);
  const float counted = static_cast<float>(count);
  const FirstLobe first = path.depth == 0 ? FirstLobe::diffuse : path.first_lobe;
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
    const float length = light.distance * (1 - shadow_margin) - scene.light_errors[light.light];
    if (!(length > 0)) continue;
    ++trace.rays;
    const Color passed = transmittance(scene, at.leave(light.wi, length, path.ray));
    if (is_black(passed)) continue;
    const float by_light = light.pdf * counted;
    const float weight = power_heuristic(by_light, scattered.pdf);
    record.add(path.throughput * scattered.value * light.radiance * passed * (weight / by_light),
               first, path.depth + 1, scene.lights[light.light].group);
  }
}

void describe_first(const Trace& trace, const Interaction& at, const Closure& closure,
                    const Ray& ray, SampleRecord& record) {
  record.alpha = 1;
  if (!trace.aovs) return;
  const Color seen = albedo(closure);
  // What only emits has its colour there, clipped: denoisers want an edge where the picture has
  // one.
  record.albedo = closure.count > 0 ? seen
                                    : Color{std::min(closure.emission.r, 1.0F),
                                            std::min(closure.emission.g, 1.0F),
                                            std::min(closure.emission.b, 1.0F)};
  record.normal = closure.shading.n;
  record.z = trace.camera.depth(ray.direction, at.t);
}

/// Takes the step that was drawn. False if roulette ended the path.
bool advance(PathState& path, const Interaction& at, const BsdfSample& drawn, float roulette) {
  if (path.depth == 0) path.first_lobe = lobe_of(drawn);
  path.throughput *= drawn.weight;
  path.eta_squared *= drawn.eta * drawn.eta;
  if (drawn.transmission) {
    if (dot(drawn.wi, at.shading.normal) < 0) {
      path.media.enter(at.material);
    } else {
      path.media.leave(at.material);
    }
  }
  path.last_pdf = drawn.pdf;
  path.last_lobe = drawn.kind;
  path.last_specular = drawn.specular;
  ++path.depth;
  if (path.depth >= roulette_from) {
    const float survival = std::min(1.0F, max_component(path.throughput) * path.eta_squared);
    if (roulette >= survival) return false;
    path.throughput *= 1 / survival;
  }
  path.ray = at.leave(drawn.wi, std::numeric_limits<float>::infinity(), path.ray);
  return true;
}

}  // namespace

void path(Trace& trace, const Sampler& sampler, const Ray& ray, SampleRecord& record) {
  const Scene& scene = trace.scene;
  Closure& closure = trace.closure;
  const bool lit = !scene.lights.empty();
  const auto light_samples = static_cast<std::uint32_t>(trace.light_samples);
  PathState path;
  path.ray = ray;
  for (;;) {
    ++trace.rays;
    const accel::Hit hit = scene.intersect(path.ray);
    if (!hit.any()) return add_environment(trace, path, record);
    // A large scene's face is not in the caches, and its corners come after its indices: the random
    // numbers are made while memory answers.
    const auto depth = static_cast<std::uint32_t>(path.depth);
    const Geometry& geometry = scene.geometry_of(hit);
    prefetch_face(geometry, hit.primitive);
    const Draw4 draw = sampler.draw4(dim::bsdf_set(depth));
    prefetch_corners(geometry, hit.primitive);
    const Draw4 light_draw = sampler.draw4(dim::light_set(depth), 0, light_samples);

    const Interaction at = surface_at(scene, path.ray, hit);
    evaluate(scene.materials[at.material], at.shading, closure);
    if (path.depth == 0) describe_first(trace, at, closure, path.ray, record);
    add_emission(trace, path, at, closure.emission, record);
    if (path.depth > trace.bounces || closure.count == 0) return;

    path.last_context = light_context(at, closure, path);
    if (closure.has_smooth && lit) add_direct(trace, sampler, light_draw, path, at, record);
    const BsdfSample drawn = sample(closure, at.shading.wo, draw[dim::lobe], draw.pair(dim::bsdf));
    if (!drawn || !advance(path, at, drawn, draw[dim::roulette])) return;
  }
}

}  // namespace tessera::render
