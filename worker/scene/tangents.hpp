#pragma once
#include <array>
#include <vector>

#include "common/scene/description.hpp"

namespace tessera::worker {

/// Tangents for a mesh that has normals and uvs: at each vertex the directions in which u grows on
/// its faces, laid into its tangent plane and weighed by the faces' angles there, as MikkTSpace
/// (Mikkelsen 2008) has it; where faces that share a vertex mirror the picture both ways the larger
/// angle has its sign. (0, 0, 0) where no face says anything.
std::vector<std::array<float, 4>> tangents_of(const scene::Mesh& mesh);

}  // namespace tessera::worker
