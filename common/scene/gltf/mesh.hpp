#pragma once
#include <optional>
#include <string>

#include "common/scene/gltf/accessor.hpp"
#include "common/scene/gltf/pose.hpp"

namespace tessera::scene::gltf {

/// What a primitive became.
struct PosedMesh {
  Mesh mesh;
  bool in_world = false;  ///< moved by joints, so that its node's place says nothing any more
};

/// A primitive as triangles, bent as `pose` says, every index in range, normals with a length or
/// none. Nothing, and a warning, where it has no area: points, lines, no positions, no triangles.
/// `place` is its JSON pointer.
std::optional<PosedMesh> read_primitive(Asset& asset, Accessors& accessors,
                                        const tinygltf::Primitive& primitive, const Pose& pose,
                                        const std::string& place);

}  // namespace tessera::scene::gltf
