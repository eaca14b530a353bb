#pragma once
#include "worker/render/lights/light_tree.hpp"

namespace tessera::render {

/// What a LightTree is made of.
struct BuiltLightTree {
  std::vector<LightNode> nodes;
  std::vector<std::uint64_t> ways;
};

/// From the top down, by the surface area orientation heuristic over 12 cells along each axis; the
/// square of the diagonal stands for the surface, so that lights in a row or a plane are told apart
/// too. Uses the threads of the calling TBB arena; the result does not depend on them.
BuiltLightTree build_light_tree(std::span<const Light> lights);

}  // namespace tessera::render
