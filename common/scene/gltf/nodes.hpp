#pragma once
#include <array>
#include <vector>

#include "common/scene/gltf/asset.hpp"

namespace tessera::scene::gltf {

using Quaternion = std::array<double, 4>;  ///< x, y, z, w

/// Scale first, then rotation, then translation. The quaternion need not be of unit length.
Transform transform_from(const Vec3& translation, const Quaternion& rotation, const Vec3& scale);
/// Translation · rotation · scale, or the matrix, of a node.
Transform local_transform(const tinygltf::Node& node);

/// A node of the scene that is shown, and where it stands in the world.
struct PlacedNode {
  int node = 0;
  Transform to_world;
};

/// The nodes of the file's scene (or its first; without any, all that are no node's child), each
/// before its children, in the file's order. Throws Error where a node is reached twice: a cycle,
/// or two parents.
std::vector<PlacedNode> placed_nodes(Asset& asset);

}  // namespace tessera::scene::gltf
