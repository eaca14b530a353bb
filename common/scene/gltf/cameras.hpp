#pragma once
#include <optional>
#include <vector>

#include "common/scene/gltf/nodes.hpp"

namespace tessera::scene::gltf {

/// The file's cameras where their nodes stand, in the nodes' order; no two have one name.
std::vector<Camera> read_cameras(Asset& asset, const std::vector<PlacedNode>& nodes);

/// Width over height of the first of them, if the file says it.
std::optional<double> aspect_of_first(const Asset& asset, const std::vector<PlacedNode>& nodes);

}  // namespace tessera::scene::gltf
