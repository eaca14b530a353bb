#include "common/scene/outline.hpp"

#include <algorithm>

namespace tessera::scene {

namespace {

std::vector<std::array<float, 3>> corners_of_box(
    const std::vector<std::array<float, 3>>& positions) {
  if (positions.empty()) return {};
  std::array<float, 3> low = positions.front(), high = low;
  for (const auto& p : positions)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  std::vector<std::array<float, 3>> out(8);
  for (std::size_t corner = 0; corner < out.size(); ++corner)
    for (std::size_t axis = 0; axis < 3; ++axis)
      out[corner][axis] = (corner >> axis & 1) != 0 ? high[axis] : low[axis];
  return out;
}

}  // namespace

MeshSize size_of(const Mesh& mesh) {
  if (mesh.outlined) return *mesh.outlined;
  return {.positions = mesh.positions.size(),
          .normals = mesh.normals.size(),
          .uvs = mesh.uvs.size(),
          .uvs1 = mesh.uvs1.size(),
          .tangents = mesh.tangents.size(),
          .colors = mesh.colors.size(),
          .triangles = mesh.triangles.size()};
}

void keep_outline(Mesh& mesh) {
  const MeshSize size = size_of(mesh);
  Mesh out;
  out.positions = corners_of_box(mesh.positions);
  out.outlined = size;
  mesh = std::move(out);
}

}  // namespace tessera::scene
