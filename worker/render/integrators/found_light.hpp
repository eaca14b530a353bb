#pragma once
#include "worker/render/integrators/passing.hpp"

/// Light that comes straight from lights along the ray with which a path has just left a surface.
/// As for light samples, what meets shadow rays alone stands in its way, and a light shines
/// whatever it is hidden from. So both ways of finding light, which are weighed against each other,
/// find the same.
namespace tessera::render {

/// Goes along the path's ray, by which the path itself stays where it is. What becomes of what is
/// found is in `rules`:
/// - void add_far(along): the ray left the scene, which ends the way.
/// - void add_met(along, at, sent): the surface `at` sends this back along the ray, which is not
///   black and has lost what the path's medium absorbs.
/// - bool go_on(along, at, share): whether anything is left behind the surface `at`, which shadow
///   rays meet and which lets `share` of the light by, 0…1; may change along.throughput.
template <class Rules>
[[gnu::always_inline]] inline void find_light(Trace& trace, const PathState& path, Rules rules) {
  const Scene& scene = trace.scene;
  PathState along = path;
  ++trace.rays;
  for (int surfaces = 0; surfaces < passes_most; ++surfaces) {
    const accel::Hit hit = scene.intersect(along.ray);
    if (!hit.any()) return rules.add_far(along);
    const Interaction at = surface_at(scene, along.ray, hit);
    const CompiledMaterial& material = scene.materials[at.material];
    if (material.emits()) {
      const Color sent =
          emission(material, scene.textures, at.shading) * absorbed_along(scene, along.media, at.t);
      if (!is_black(sent)) rules.add_met(along, at, sent);
    }
    if (scene.visibility_of(at.placement, at.geometry).shadow &&
        !rules.go_on(along, at, passing_share(scene, at)))
      return;
    along.ray.t_min = at.behind(along.ray);
  }
}

/// For scenes that are lit apart: adds what is found, each times weight(light, hit).
template <class Weight>
[[gnu::noinline]] void add_found_light(Trace& trace, const PathState& path, Weight weight,
                                       SampleRecord& record) {
  struct Rules {
    Trace& trace;
    const Weight& weight;
    SampleRecord& record;

    void add_far(const PathState& along) { render::add_far(trace, along, weight, record); }
    void add_met(const PathState& along, const Interaction& at, const Color& sent) {
      add_emission(trace, along, at, sent, weight(at.light, light_hit(along, at)), record);
    }
    bool go_on(PathState& along, const Interaction& /*at*/, float share) {
      if (!(share > 0)) return false;
      along.throughput *= share;
      return !is_black(along.throughput);
    }
  };
  find_light(trace, path, Rules{trace, weight, record});
}

}  // namespace tessera::render
