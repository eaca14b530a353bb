#pragma once
#include <optional>
#include <string>

#include "common/scene/gltf/accessor.hpp"

namespace tessera::scene::gltf {

/// A primitive as triangles, every index in range, normals with a length or none. Nothing, and a
/// warning, where it has no area: points, lines, no positions, no triangles. `place` is its JSON
/// pointer.
std::optional<Mesh> read_primitive(Asset& asset, Accessors& accessors,
                                   const tinygltf::Primitive& primitive, const std::string& place);

}  // namespace tessera::scene::gltf
