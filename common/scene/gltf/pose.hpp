#pragma once
#include <string>
#include <vector>

#include "common/scene/gltf/accessor.hpp"
#include "common/scene/gltf/nodes.hpp"

namespace tessera::scene::gltf {

/// How a primitive is bent: by weights of its morph targets, and by the joints of a skin.
struct Pose {
  std::vector<double> weights;    ///< of the targets; those beyond count 0
  std::vector<Transform> joints;  ///< from the mesh's space to the world; empty: no skin
};

/// The pose of a node's mesh. `worlds` has the place of every node in the world, by its number, and
/// nothing for nodes that are not in the scene. Throws Error for a joint that is not.
Pose pose_of(const Asset& asset, Accessors& accessors, int node,
             const std::vector<const Transform*>& worlds);

/// Adds the morph targets' parts to positions, normals and tangents.
void morph(const Asset& asset, Accessors& accessors, const tinygltf::Primitive& primitive,
           const Pose& pose, const std::string& place, Mesh& mesh);

/// Moves positions, normals and tangents with the joints, into the world. False where the primitive
/// says nothing of joints, and nothing was moved.
bool skin(const Asset& asset, Accessors& accessors, const tinygltf::Primitive& primitive,
          const Pose& pose, const std::string& place, Mesh& mesh);

}  // namespace tessera::scene::gltf
