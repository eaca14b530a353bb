#pragma once
#include <vector>

#include "common/scene/gltf/accessor.hpp"

namespace tessera::scene::gltf {

/// Where the copies of a node's mesh stand in the node's space: as EXT_mesh_gpu_instancing says, or
/// the one at its origin.
std::vector<Transform> copies_of(const Asset& asset, Accessors& accessors, int node);

}  // namespace tessera::scene::gltf
