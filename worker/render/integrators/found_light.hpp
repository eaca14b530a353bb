#pragma once
#include "worker/render/integrators/passing.hpp"

namespace tessera::render {

/// For scenes that are lit apart: adds the light that comes straight from lights along the ray with
/// which the path has just left a surface, each times weight(light, hit). As for light samples,
/// what meets shadow rays alone stands in its way, and a light shines whatever it is hidden from.
/// So both ways of finding light, which are weighed against each other, find the same.
template <class Weight>
[[gnu::noinline]] void add_found_light(Trace& trace, const PathState& path, Weight weight,
                                       SampleRecord& record) {
  const Scene& scene = trace.scene;
  PathState along = path;
  for (int surfaces = 0; surfaces < passes_most; ++surfaces) {
    ++trace.rays;
    const accel::Hit hit = scene.intersect(along.ray);
    if (!hit.any()) return add_far(trace, along, weight, record);
    const Interaction at = surface_at(scene, along.ray, hit);
    const CompiledMaterial& material = scene.materials[at.material];
    if (material.emits()) {
      const Color sent =
          emission(material, scene.textures, at.shading) * absorbed_along(scene, along.media, at.t);
      if (!is_black(sent))
        add_emission(trace, along, at, sent, weight(at.light, light_hit(along, at)), record);
    }
    if (scene.visibility_of(at.placement, at.geometry).shadow) {
      if (!material.has_opacity && !material.back_culled) return;
      along.throughput *= 1 - presence(material, scene.textures, at.shading);
      if (is_black(along.throughput)) return;
    }
    along.ray.t_min = at.behind(along.ray);
  }
}

}  // namespace tessera::render
