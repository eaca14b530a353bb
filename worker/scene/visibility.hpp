#pragma once
#include "worker/render/scene.hpp"

namespace tessera::worker {

/// The mask of what has this visibility; that of what hides from no ray is met by rays of any kind.
accel::Mask mask_of(const scene::Visibility& visibility);

/// Notes what the visibility of a scene's placements and geometries asks of integrators.
void note_visibility(render::Scene& scene);

}  // namespace tessera::worker
