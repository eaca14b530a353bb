#pragma once
#include "common/scene/gltf/accessor.hpp"

namespace tessera::scene::gltf {

/// Puts every node where the file's animations have it at `time`, in seconds: its translation,
/// rotation, scale and morph weights. Where several animations move one property of a node, the
/// first does. Before a sampler's first time and after its last it stands still. Throws Error where
/// times do not grow, or there are not as many values as times.
void animate(Asset& asset, Accessors& accessors, double time);

/// The time of the last key of all animations; 0 without any.
double last_key(Asset& asset, Accessors& accessors);

}  // namespace tessera::scene::gltf
