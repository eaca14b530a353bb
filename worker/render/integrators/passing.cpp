#include "worker/render/integrators/passing.hpp"

#include <cmath>

#include "worker/render/fastmath.hpp"

namespace tessera::render {
namespace {

constexpr std::size_t nowhere = ~std::size_t{0};

/// Which of the media counts, leaving out number `without`.
std::size_t strongest(const Scene& scene, const MediumStack& media, std::size_t without) {
  std::size_t best = nowhere;
  std::int32_t most = 0;
  for (std::size_t i = 0; i < media.size(); ++i) {
    const std::int32_t priority = scene.materials[media[i]].medium.priority;
    if (i == without || (best != nowhere && priority < most)) continue;
    best = i;
    most = priority;
  }
  return best;
}

std::size_t last_of(const MediumStack& media, std::uint32_t material) {
  for (std::size_t i = media.size(); i-- > 0;) {
    if (media[i] == material) return i;
  }
  return nowhere;
}

Color exp_of(const Color& absorption, float length) {
  return {fast::exp(-absorption.r * length), fast::exp(-absorption.g * length),
          fast::exp(-absorption.b * length)};
}

}  // namespace

Crossing crossing_of(const Scene& scene, const MediumStack& media, std::uint32_t material,
                     bool entering) {
  const std::size_t own = entering ? nowhere : last_of(media, material);
  const std::size_t other = strongest(scene, media, own);
  if (other == nowhere) return {};
  const Medium& around = scene.materials[media[other]].medium;
  const std::int32_t priority = scene.materials[material].medium.priority;
  const bool entered_later = own == nowhere || own > other;
  return {.real = priority > around.priority || (priority == around.priority && entered_later),
          .outside_ior = around.ior};
}

const Medium* medium_of(const Scene& scene, const MediumStack& media) {
  const std::size_t best = strongest(scene, media, nowhere);
  return best == nowhere ? nullptr : &scene.materials[media[best]].medium;
}

Color absorbed_along(const Scene& scene, const MediumStack& media, float length) {
  const Medium* const medium = medium_of(scene, media);
  if (medium == nullptr || std::isinf(length)) return gray(1);
  return exp_of(medium->absorption, length);
}

void absorb(const Trace& trace, PathState& path, float t) {
  path.throughput *= absorbed_along(trace.scene, path.media, t - path.passed_to);
}

bool passes(const Trace& trace, const Sampler& sampler, PathState& path, Interaction& at) {
  const CompiledMaterial& material = trace.scene.materials[at.material];
  const float share = presence(material, trace.scene.textures, at.shading);
  bool passed = share < 1 && alpha_number(sampler.hash(),
                                          static_cast<std::uint32_t>(path.depth) * passes_most +
                                              static_cast<std::uint32_t>(path.passes),
                                          at.instance, at.primitive) >= share;
  if (!passed && material.interface) {
    const bool entering = dot(at.shading.wo, at.shading.normal) > 0;
    const Crossing crossing = crossing_of(trace.scene, path.media, at.material, entering);
    at.shading.outside_ior = crossing.outside_ior;
    if (!crossing.real) {
      path.media.cross(at.material, entering);
      // A light sample does not see through it, so what the ray finds counts in full.
      if (trace.scene.visibility_of(at.placement, at.geometry).shadow) path.last_specular = true;
      passed = true;
    }
  }
  if (!passed) return false;
  path.ray.t_min = at.behind(path.ray);
  path.passed_to = at.t;
  ++path.passes;
  return true;
}

}  // namespace tessera::render
