#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "worker/render/at_once.hpp"
#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/camera.hpp"
#include "worker/render/integrators/questions.hpp"
#include "worker/render/record.hpp"
#include "worker/render/sampler.hpp"
#include "worker/render/scene.hpp"

namespace tessera::render {

/// What every sample of a task shares, and what the thread that takes it uses again from sample to
/// sample.
struct Trace {
  const Scene& scene;
  const Camera& camera;
  int bounces = 0;               ///< 0 is emission and direct light; counted as Cycles does
  int light_samples = 1;         ///< at each hit
  bool aovs = false;             ///< albedo, normal and z are wanted
  bool follow_specular = false;  ///< albedo and normal are those of the first hit that is no delta
  std::int64_t rays = 0;         ///< counted up; one that goes through surfaces is one
  bool by_lobe = false;          ///< PathState::first is wanted
  bool coordinates = false;      ///< the first hit's texture coordinates are wanted
  bool identities = false;       ///< so is what it belongs to
  // What is too large to be made anew for each hit:
  std::array<Closure, samples_at_once> closures;  ///< of the hits that are looked at
  Questions questions;
};

/// One sample of a pixel.
struct CameraSample {
  Sampler sampler;      ///< its numbers
  Ray ray;              ///< as it leaves the camera
  SampleRecord record;  ///< what it saw; fresh at first
};
/// Takes up to samples_at_once samples, of any pixels: follows each one's ray and writes what it
/// saw into its record. None depends on the others.
using Integrator = void (*)(Trace& trace, std::span<CameraSample> samples);

/// From a name of the table in integrator.cpp; throws Error{bad_input} that lists the valid names.
Integrator integrator(std::string_view name);
/// The valid names, the default first.
std::vector<std::string_view> integrator_names();

}  // namespace tessera::render
