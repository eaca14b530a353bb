#pragma once
#include <algorithm>
#include <array>
#include <limits>

#include "worker/render/integrators/integrator.hpp"
#include "worker/render/integrators/path_state.hpp"
#include "worker/render/interaction.hpp"
#include "worker/render/light_point.hpp"

/// The steps that integrators are put together from.
namespace tessera::render {

/// Paths are ended only where less than a third of the light that they carry would be left. What
/// light falls in one bounce on is of the same order as what is seen at once, but stratifies worse:
/// to end paths sooner saves fewer rays than it makes noise (tests/bench/README.md).
inline constexpr float roulette_reluctance = 3;
/// A shadow ray ends this part of its length before the light.
inline constexpr float shadow_margin = 0x1p-13F;

/// What the path's ray meets, by its mask.
inline accel::Mask mask_of(const PathState& path) {
  return path.depth == 0 ? ray_mask::camera : ray_mask::indirect;
}

/// True if the path's ray was asked for lights apart from what it runs into (found_light.hpp).
inline bool is_lit_apart(const Trace& trace, const PathState& path) {
  return trace.scene.lit_apart && !path.last_specular;
}

/// A light's point that the path ran into.
inline LightHit light_hit(const PathState& path, const Interaction& at) {
  LightHit hit;
  hit.wi = path.ray.direction;
  hit.distance = at.t;
  hit.instance = at.instance;
  hit.primitive = at.primitive;
  return hit;
}

/// Adds the environment and suns that a path which left the scene runs into, each times
/// weight(light, hit).
template <class Weight>
void add_far(const Trace& trace, const PathState& path, Weight weight, SampleRecord& record) {
  LightHit hit;
  hit.wi = path.ray.direction;
  for (const std::uint32_t light : trace.scene.lights.seen_far()) {
    const Light& far = trace.scene.lights[light];
    const Color sent = emitted(far, path.last_context, path.ray.direction);
    if (is_black(sent)) continue;
    record.add(path.throughput * sent * weight(light, hit), path.first, path.depth, far.group);
  }
}

/// What a path sees that met nothing.
template <class Weight>
void see_far(const Trace& trace, const PathState& path, Weight weight, SampleRecord& record) {
  if (path.depth == 0) {
    if (trace.scene.film_transparent) return;
    if (trace.scene.has_environment) record.alpha = 1;
  }
  if (!is_lit_apart(trace, path)) add_far(trace, path, weight, record);
}

/// Adds what the surface that the path met emits, times `weight`.
inline void add_emission(const Trace& trace, const PathState& path, const Interaction& at,
                         const Color& emission, float weight, SampleRecord& record) {
  record.add(path.throughput * emission * weight, path.first, path.depth,
             trace.scene.materials[at.material].light_group);
}

/// Adds what the surface emits that the path met and whose closure is given.
template <class Weight>
void see_emission(const Trace& trace, const PathState& path, const Interaction& at,
                  const Closure& closure, Weight weight, SampleRecord& record) {
  const Color& emission = closure.emission;
  if (is_black(emission)) return;
  if (is_lit_apart(trace, path) && trace.scene.materials[at.material].emits()) return;
  add_emission(trace, path, at, emission, weight(at.light, light_hit(path, at)), record);
}

/// What the camera's ray met.
inline void describe_place(const Trace& trace, const accel::Hit& hit, const Interaction& at,
                           const Ray& ray, SampleRecord& record) {
  record.alpha = 1;
  if (trace.aovs) record.z = trace.camera.depth(ray.direction, at.t);
  if (record.extras == nullptr) return;
  const std::array<double, 3>& origin = trace.scene.origin;
  record.extras->position = {static_cast<float>(static_cast<double>(at.p.x) + origin[0]),
                             static_cast<float>(static_cast<double>(at.p.y) + origin[1]),
                             static_cast<float>(static_cast<double>(at.p.z) + origin[2])};
  if (trace.coordinates) record.extras->uv = surface_uv(trace.scene.geometry_of(hit), hit);
  if (trace.identities) {
    record.extras->object = trace.scene.object_of(hit);
    record.extras->material = trace.scene.material_identities[at.material];
  }
}

/// What is told of the hit of a path that is undescribed: alpha and, if they are wanted, the other
/// channels. Open Image Denoise's documentation says what albedo and normals it likes.
inline void describe(const Trace& trace, const accel::Hit& hit, const Interaction& at,
                     const Closure& closure, PathState& path, SampleRecord& record) {
  if (path.depth == 0) describe_place(trace, hit, at, path.ray, record);
  path.undescribed = trace.follow_specular && closure.count > 0 && !closure.has_smooth;
  if (!trace.aovs || path.undescribed) return;
  const Color seen = albedo(closure);
  // What only emits has its colour there, clipped: denoisers want an edge where the picture has
  // one.
  record.albedo = closure.count > 0 ? seen
                                    : Color{std::min(closure.emission.r, 1.0F),
                                            std::min(closure.emission.g, 1.0F),
                                            std::min(closure.emission.b, 1.0F)};
  record.normal = closure.shading.n;
  if (path.depth > 0) {
    const Color tinted = record.albedo * path.throughput * path.eta_squared;
    record.albedo = {std::min(tinted.r, 1.0F), std::min(tinted.g, 1.0F), std::min(tinted.b, 1.0F)};
  }
}

/// Where light samples are taken from: the side of wo, unless light may come from both; where lobes
/// have frames of their own, by the geometric normal, across which none of them scatters. That is
/// also where the ray to the light starts, so that a light which scatters too finds its own points
/// on the right side of itself.
inline LightContext light_context(const Interaction& at, const Closure& closure,
                                  const PathState& path) {
  LightContext context;
  context.p = at.p;
  context.medium = path.media.innermost();
  if ((closure.flags & lobe_flag::transmission) == 0) {
    const Vec3& n = closure.frame_count > 0 ? closure.normal : closure.shading.n;
    context.n = dot(n, at.shading.wo) < 0 ? -n : n;
    context.p = at.start(at.shading.wo);
  }
  return context;
}

/// What the strongest of the media leaves of light along `length`. Of an endless way all: a medium
/// without a far side is open, and so is none.
Color absorbed_along(const Scene& scene, const MediumStack& media, float length);

/// Gives a ray from `at` its start. False where none leaves like this: below a face that has
/// nothing round over it.
inline bool leaves(const Trace& trace, const Interaction& at, const Closure& closure, Ray& ray) {
  if (!closure.rounded) return true;
  const Vec3& n = at.shading.normal;
  return dot(ray.direction, n) * dot(at.shading.wo, n) >= 0 || leave_rounded(trace.scene, at, ray);
}

/// The radiance of a light's sample that reaches `at`. Counts its shadow ray.
inline Color light_from(Trace& trace, const Interaction& at, const Closure& closure,
                        const LightSample& light, const PathState& path) {
  const Scene& scene = trace.scene;
  const float length = light.distance * (1 - shadow_margin) - scene.light_errors[light.light];
  if (!(length > 0)) return {};
  Ray ray = at.leave(light.wi, length, path.ray);
  if (!leaves(trace, at, closure, ray)) return {};
  const bool varies = scene.lights[light.light].varies;
  const Color sent = varies ? radiance_at(scene, light, ray) : light.radiance;
  if (varies && is_black(sent)) return {};
  ++trace.rays;
  const Color passed = sent * transmittance(scene, ray);
  const bool interface = scene.materials[at.material].interface;
  if ((path.media.size() == 0 && !interface) || is_black(passed)) return passed;
  MediumStack media = path.media;
  const float out = dot(light.wi, at.shading.normal);
  if (interface && out * dot(at.shading.wo, at.shading.normal) < 0) {
    media.cross(at.material, out < 0);
  }
  return passed * absorbed_along(scene, media, length);
}

/// Adds what a light's sample brought to where the path is and goes on along the path.
inline void add_lit(const Trace& trace, const PathState& path, const Interaction& at,
                    const Closure& closure, const LightSample& light, const Color& brought,
                    SampleRecord& record) {
  const std::uint16_t group = trace.scene.lights[light.light].group;
  if (trace.by_lobe && path.depth == 0)
    record.add(brought, lobe_shares(closure, at.shading.wo, light.wi), 1, group);
  else
    record.add(brought, path.first, path.depth + 1, group);
}

/// Scatters the path as was drawn: all of the step but the ray.
inline void scatter(const Trace& trace, PathState& path, const Interaction& at,
                    const Closure& closure, const BsdfSample& drawn) {
  if (trace.by_lobe && path.depth == 0) path.first = lobe_shares(closure, at.shading.wo, drawn);
  path.throughput *= drawn.weight;
  path.eta_squared *= drawn.eta * drawn.eta;
  if (drawn.transmission && trace.scene.materials[at.material].interface) {
    path.media.cross(at.material, dot(drawn.wi, at.shading.normal) < 0);
  }
  path.passed_to = 0;
  path.last_pdf = drawn.pdf;
  path.last_lobe = drawn.kind;
  path.last_specular = drawn.specular;
  ++path.depth;
}

/// Roulette on throughput·η²: false if it ends the path; who survives carries more for it.
inline bool survives(PathState& path, float roulette) {
  const float carried = max_component(path.throughput) * path.eta_squared;
  const float survival = std::min(1.0F, roulette_reluctance * carried);
  if (roulette >= survival) return false;
  path.throughput *= 1 / survival;
  return true;
}

/// Sets out on the step that was drawn. False if nothing leaves that way.
inline bool set_out(const Trace& trace, PathState& path, const Interaction& at,
                    const Closure& closure, const BsdfSample& drawn) {
  path.ray = at.leave(drawn.wi, std::numeric_limits<float>::infinity(), path.ray);
  return leaves(trace, at, closure, path.ray);
}

/// Takes the step that was drawn. False if the path ends here.
inline bool advance(const Trace& trace, PathState& path, const Interaction& at,
                    const Closure& closure, const BsdfSample& drawn, float roulette) {
  scatter(trace, path, at, closure, drawn);
  return survives(path, roulette) && set_out(trace, path, at, closure, drawn);
}

}  // namespace tessera::render
