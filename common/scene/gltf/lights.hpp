#pragma once
#include <vector>

#include "common/scene/gltf/gltf.hpp"
#include "common/scene/gltf/nodes.hpp"

namespace tessera::scene::gltf {

/// KHR_lights_punctual: candela and lux, by `units`; a node's scale says nothing.
/// Lights that give none are left out.
std::vector<PunctualLight> read_lights(Asset& asset, const std::vector<PlacedNode>& nodes,
                                       Units units);

}  // namespace tessera::scene::gltf
