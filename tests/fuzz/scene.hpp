#pragma once
#include "common/scene/scene_file.hpp"

namespace tessera::fuzz {

/// What a scene's description promises to whoever renders it: indices name what is there, numbers
/// are finite, transforms can be undone.
void check(const scene::Scene& scene);

}  // namespace tessera::fuzz
