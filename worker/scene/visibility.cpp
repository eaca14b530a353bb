#include "worker/scene/visibility.hpp"

namespace tessera::worker {

accel::Mask mask_of(const scene::Visibility& visibility) {
  accel::Mask mask = accel::everything;
  if (!visibility.camera) mask &= ~render::ray_mask::camera;
  if (!visibility.shadow) mask &= ~render::ray_mask::shadow;
  if (!visibility.indirect) mask &= ~render::ray_mask::indirect;
  return mask;
}

void note_visibility(render::Scene& scene) {
  for (const render::Placement& placement : scene.placements) {
    for (const render::Geometry& geometry : scene.groups[placement.group].geometries) {
      const scene::Visibility seen = placement.visibility & geometry.visibility;
      scene.has_holes = scene.has_holes || seen.holdout || seen.shadow_catcher;
      scene.has_catchers = scene.has_catchers || seen.shadow_catcher;
      scene.lit_apart =
          scene.lit_apart || seen.shadow != seen.indirect || (geometry.emits() && !seen.indirect);
    }
  }
}

}  // namespace tessera::worker
