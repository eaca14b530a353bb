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

/// Made where it stands: it is too large to be moved.
struct Met {
  Interaction at;
  Met(const Scene& scene, const Ray& ray, const accel::Hit& hit)
      : at(surface_at(scene, ray, hit)) {}
};

/// A path that is under way, and the surface that it is at.
struct Lane {
  CameraSample& sample;
  Closure& closure;
  PathState path;
  accel::Hit hit;
  std::optional<Met> met;

  Lane(CameraSample& taken, Closure& of) : sample(taken), closure(of) { path.ray = taken.ray; }
};
using Lanes = std::span<Lane* const>;

/// What becomes of a path at what it met.
enum class Fate : std::uint8_t {
  ends,
  goes_on,   ///< along the same ray
  scatters,  ///< the lane's closure says how
};

/// Looks at what the lane's ray met.
Fate arrive(Trace& trace, Lane& lane) {
  const Scene& scene = trace.scene;
  const Sampler& sampler = lane.sample.sampler;
  SampleRecord& record = lane.sample.record;
  PathState& path = lane.path;
  const FoundWeight weight{trace, path};
  if (!lane.hit.any()) {
    see_far(trace, path, weight, record);
    return Fate::ends;
  }
  Interaction& at = lane.met.emplace(scene, path.ray, lane.hit).at;
  const CompiledMaterial& material = scene.materials[at.material];
  if (path.media.size() > 0) absorb(trace, path, at.t);
  if (material.may_pass && passes(trace, sampler, path, at))
    return path.passes == passes_most ? Fate::ends : Fate::goes_on;
  Closure& closure = lane.closure;
  evaluate(material, scene.textures, at.shading, closure);
  if (path.undescribed) {
    if (is_hole(trace, sampler, path, at, closure, record)) return Fate::ends;
    describe(trace, lane.hit, at, closure, path, record);
  }
  see_emission(trace, path, at, closure, weight, record);
  if (path.depth > trace.bounces || closure.count == 0) return Fate::ends;
  path.last_context = light_context(at, closure, path);
  return Fate::scatters;
}

/// Adds what a light's sample, one of `count`, brings to where the path is.
void add_light(Trace& trace, Lane& lane, const LightSample& light, const Scattering& scattered,
               float count) {
  if (is_black(scattered.value)) return;
  const Interaction& at = lane.met->at;
  const PathState& path = lane.path;
  const Color arriving = light_from(trace, at, lane.closure, light, path);
  if (is_black(arriving)) return;
  const float by_light = light.pdf * count;
  const float weight = light.delta ? 1 : power_heuristic(by_light, scattered.pdf);
  add_lit(trace, path, at, lane.closure, light,
          path.throughput * scattered.value * arriving * (weight / by_light), lane.sample.record);
}

/// Adds the lights' samples, one of `count` for each lane.
void add_lights(Trace& trace, Lanes lanes, float count) {
  Questions& questions = trace.questions;
  std::size_t some = 0;
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    const LightSample& light = questions.lights[i];
    if (!light || is_black(light.radiance)) continue;
    questions.scatterings[some] = {&lanes[i]->closure, lanes[i]->met->at.shading.wo, light.wi};
    questions.places[some++] = i;
  }
  questions.batch.scattering({questions.scatterings.data(), some}, questions.scattered);
  for (std::size_t k = 0; k < some; ++k) {
    const std::size_t i = questions.places[k];
    add_light(trace, *lanes[i], questions.lights[i], questions.scattered[k], count);
  }
}

/// Light samples for all lanes.
void add_direct(Trace& trace, Lanes lanes) {
  const LightTable& lights = trace.scene.lights;
  if (lights.empty()) return;
  auto& asked = trace.questions.light_requests;
  const auto count = static_cast<std::uint32_t>(trace.light_samples);
  for (std::uint32_t j = 0; j < count; ++j) {
    for (std::size_t i = 0; i < lanes.size(); ++i) {
      const PathState& path = lanes[i]->path;
      const std::uint32_t set = dim::light_set(static_cast<std::uint32_t>(path.depth));
      const Draw4 draw = lanes[i]->sample.sampler.draw4(set, j, count);
      asked[i] = {&path.last_context, draw.bits(dim::light_pick), draw.pair(dim::light)};
    }
    lights.sample({asked.data(), lanes.size()}, trace.questions.lights);
    add_lights(trace, lanes, static_cast<float>(count));
  }
}

/// Lanes of some kind.
struct Chosen {
  std::array<Lane*, samples_at_once> lanes{};
  std::size_t count = 0;

  void add(Lane& lane) { lanes[count++] = &lane; }
  [[nodiscard]] Lanes all() const { return {lanes.data(), count}; }
};

/// Takes the next step of a path that scatters. False if it ends there.
bool step(Trace& trace, Lane& lane, const BsdfSample& drawn, float roulette) {
  PathState& path = lane.path;
  if (!drawn || !advance(trace, path, lane.met->at, lane.closure, drawn, roulette)) return false;
  ++trace.rays;
  if (is_lit_apart(trace, path))
    add_found_light(trace, path, FoundWeight{trace, path}, lane.sample.record);
  return true;
}

/// Lets all lanes scatter: adds to `left` those that go on.
void scatter(Trace& trace, Lanes lanes, Chosen& left) {
  Questions& questions = trace.questions;
  auto& asked = questions.bsdf_requests;
  auto& roulette = questions.roulette;
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    const Lane& lane = *lanes[i];
    const std::uint32_t set = dim::bsdf_set(static_cast<std::uint32_t>(lane.path.depth));
    const Draw4 draw = lane.sample.sampler.draw4(set);
    asked[i] = {&lane.closure, lane.met->at.shading.wo, draw[dim::lobe], draw.pair(dim::bsdf)};
    roulette[i] = draw[dim::roulette];
  }
  questions.batch.sample({asked.data(), lanes.size()}, questions.drawn);
  for (std::size_t i = 0; i < lanes.size(); ++i)
    if (step(trace, *lanes[i], questions.drawn[i], roulette[i])) left.add(*lanes[i]);
}

/// What each lane's ray meets. A large scene's faces are not in the caches: they are asked for at
/// once, and their corners when the next ray is done and the indices are there.
void meet(const Scene& scene, Lanes lanes) {
  const accel::Hit* last = nullptr;
  const auto ask_for_last = [&] {
    if (last != nullptr && last->any()) prefetch_corners(scene.geometry_of(*last), last->primitive);
  };
  for (Lane* const lane : lanes) {
    lane->hit = scene.intersect(lane->path.ray, mask_of(lane->path));
    if (lane->hit.any()) prefetch_face(scene.geometry_of(lane->hit), lane->hit.primitive);
    ask_for_last();
    last = &lane->hit;
  }
  ask_for_last();
  for (const Lane* const lane : lanes)
    if (lane->hit.any()) await_surface(scene.geometry_of(lane->hit), lane->hit.primitive);
}

}  // namespace

// The other integrators share its steps, so the compiler would call them one by one; in line they
// keep their values in registers.
[[gnu::flatten]] void path(Trace& trace, std::span<CameraSample> samples) {
  assert(samples.size() <= samples_at_once);
  std::array<std::optional<Lane>, samples_at_once> lanes;
  Chosen going;
  for (CameraSample& sample : samples)
    going.add(lanes[going.count].emplace(sample, trace.closures[going.count]));
  trace.rays += static_cast<std::int64_t>(going.count);
  // All of them do one thing before any of them does the next.
  while (going.count > 0) {
    meet(trace.scene, going.all());
    Chosen left, scattering, lit;
    for (Lane* const lane : going.all()) {
      const Fate fate = arrive(trace, *lane);
      if (fate == Fate::goes_on) left.add(*lane);
      if (fate != Fate::scatters) continue;
      scattering.add(*lane);
      if (lane->closure.has_smooth) lit.add(*lane);
    }
    add_direct(trace, lit.all());
    scatter(trace, scattering.all(), left);
    going = left;
  }
}

}  // namespace tessera::render
