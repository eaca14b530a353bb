#pragma once
#include "common/scene/description.hpp"

namespace tessera::scene {

/// The least box around all that a scene shows; low beyond high where it shows nothing.
struct Bounds {
  Vec3 low{}, high{};
  [[nodiscard]] bool empty() const { return !(low[0] <= high[0]); }
};
/// Of shapes and instances; of a bent sphere, and of instances, the box around their own box.
Bounds bounds_of(const Scene& scene);

/// A camera in front (+z), a little to the right and above, that sees all that is there, in the
/// middle of a film of this width over height.
Camera view_of(const Scene& scene, double aspect);

/// True if anything in the scene shines: an environment, lights, a material that emits. (Unlit
/// surfaces show themselves and light nothing, and emission that a texture paints is what displays
/// and windows have: a scene with no other light is too dark to see the rest.)
bool has_light(const Scene& scene);

}  // namespace tessera::scene
