#pragma once
#include <algorithm>
#include <cmath>

#include "common/scene/description.hpp"
#include "tests/fuzz/target.hpp"

namespace tessera::fuzz {

template <class Rows>
void check_rows(const Rows& rows, std::size_t vertices, bool may_lack) {
  require(rows.size() == vertices || (may_lack && rows.empty()), "vertices have all their values");
  for (const auto& row : rows)
    require(std::all_of(row.begin(), row.end(), [](float x) { return std::isfinite(x); }),
            "a vertex is finite");
}

/// A mesh that was read keeps the promises of description.hpp.
inline void check(const scene::Mesh& mesh) {
  const std::size_t vertices = mesh.positions.size();
  check_rows(mesh.positions, vertices, false);
  check_rows(mesh.normals, vertices, true);
  check_rows(mesh.uvs, vertices, true);
  check_rows(mesh.uvs1, vertices, true);
  check_rows(mesh.tangents, vertices, true);
  check_rows(mesh.colors, vertices, true);
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle)
      require(corner < vertices, "a triangle names vertices that are there");
}

}  // namespace tessera::fuzz
