#pragma once
#include "common/scene/description.hpp"

namespace tessera::scene {

/// True if something in the scene catches shadows: then its jobs need Aov::shadow_catcher, in which
/// they travel.
bool has_shadow_catchers(const Scene& scene);

}  // namespace tessera::scene
