#pragma once
#include "common/scene/description.hpp"

namespace tessera::scene {

/// Makes the environment of `scene` that of a photographer's studio, with the strength and further
/// rotation of the environment that it has, if it has one: a grey
/// backdrop, a large soft panel at the upper left of `camera`, a weaker one at its right
/// and one from behind. Radiance is about 1 where a white surface faces the light.
void add_studio(Scene& scene, const Camera& camera);

}  // namespace tessera::scene
