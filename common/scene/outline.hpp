#pragma once
#include "common/scene/description.hpp"

namespace tessera::scene {

MeshSize size_of(const Mesh& mesh);

/// Lets go of a mesh but for its size and the corners of its box, which become its positions.
void keep_outline(Mesh& mesh);

}  // namespace tessera::scene
