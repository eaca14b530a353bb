#pragma once
#include <cstdint>

#include "worker/render/integrators/path_steps.hpp"

/// What a path goes through without scattering: surfaces that are not there, by chance, seen from
/// behind, or because an interface lies within a medium that counts for more.
namespace tessera::render {

/// What the path's media make of an interface that it meets.
struct Crossing {
  bool real = true;       ///< else it lies within another medium of greater priority
  float outside_ior = 1;  ///< of what is on its other side
};
/// Nested dielectrics (Schmidt and Budge 2002): where media overlap the one of the greatest
/// priority is there; among equals the one that was entered last.
Crossing crossing_of(const Scene& scene, const MediumStack& media, std::uint32_t material,
                     bool entering);

/// The medium that a path is in, by the same rule; null in the open.
const Medium* medium_of(const Scene& scene, const MediumStack& media);

/// True if the path goes on behind `at` along the same ray, which then is made so. Else what `at`
/// borders on is noted in it. To be asked where the material may_pass.
bool passes(const Trace& trace, const Sampler& sampler, PathState& path, Interaction& at);

/// Takes what the path's medium absorbs on the way to `t`. To be asked where there are media.
void absorb(const Trace& trace, PathState& path, float t);

}  // namespace tessera::render
