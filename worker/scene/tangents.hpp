#pragma once
#include <array>
#include <vector>

#include "common/scene/description.hpp"

namespace tessera::worker {

/// Gives each vertex that is shared by faces which show the picture of coordinate set 0 or 1 as it
/// is and by such as mirror it a twin for the latter, as MikkTSpace (Mikkelsen 2008) does: the two
/// have other tangents.
void part_mirrored(scene::Mesh& mesh, std::size_t uv_set);

/// Tangents for a mesh that has normals and coordinates of that set, after part_mirrored(): at each
/// vertex the directions in which u grows on its faces, laid into its tangent plane and weighed by
/// the faces' angles there, as MikkTSpace has it. (0, 0, 0) where the faces do not agree on one, or
/// none says anything.
std::vector<std::array<float, 4>> tangents_of(const scene::Mesh& mesh, std::size_t uv_set);

}  // namespace tessera::worker
