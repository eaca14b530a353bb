#include "worker/scene/tangents.hpp"

#include "worker/render/fastmath.hpp"
#include "worker/render/vec.hpp"

namespace tessera::worker {
namespace {

using render::Vec3d;

Vec3d vec(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

/// What the faces about a vertex say.
struct Gathered {
  Vec3d sum;
  double turned = 0;  ///< angles of faces that show the picture as it is, less those that mirror it
};

double angle_between(const Vec3d& a, const Vec3d& b) {
  return render::fast::acos(dot(normalize(a), normalize(b)));
}

}  // namespace

std::vector<std::array<float, 4>> tangents_of(const scene::Mesh& mesh) {
  std::vector<Gathered> gathered(mesh.positions.size());
  for (const auto& face : mesh.triangles) {
    const Vec3d a = vec(mesh.positions[face[0]]);
    const Vec3d edge1 = vec(mesh.positions[face[1]]) - a, edge2 = vec(mesh.positions[face[2]]) - a;
    const auto uv_edge = [&](std::size_t i) {
      return std::array<double, 2>{double{mesh.uvs[face[i]][0]} - double{mesh.uvs[face[0]][0]},
                                   double{mesh.uvs[face[i]][1]} - double{mesh.uvs[face[0]][1]}};
    };
    const auto uv1 = uv_edge(1), uv2 = uv_edge(2);
    const double area = uv1[0] * uv2[1] - uv1[1] * uv2[0];
    if (area == 0) continue;
    const double turn = area < 0 ? -1 : 1;
    const Vec3d along_u = normalize(edge1 * uv2[1] - edge2 * uv1[1]) * turn;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3d at = vec(mesh.positions[face[i]]);
      const double angle = angle_between(vec(mesh.positions[face[(i + 1) % 3]]) - at,
                                         vec(mesh.positions[face[(i + 2) % 3]]) - at);
      const Vec3d n = normalize(vec(mesh.normals[face[i]]));
      Gathered& vertex = gathered[face[i]];
      vertex.sum += normalize(along_u - n * dot(n, along_u)) * angle;
      // v runs down, so a picture that is shown as it is turns against the corners' order.
      vertex.turned -= turn * angle;
    }
  }
  std::vector<std::array<float, 4>> out;
  out.reserve(gathered.size());
  for (const Gathered& vertex : gathered) {
    const render::Vec3 t = to_float(normalize(vertex.sum));
    out.push_back({t.x, t.y, t.z, vertex.turned < 0 ? -1.0F : 1.0F});
  }
  return out;
}

}  // namespace tessera::worker
