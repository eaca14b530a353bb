#include "worker/scene/tangents.hpp"

#include "worker/render/fastmath.hpp"
#include "worker/render/vec.hpp"

namespace tessera::worker {
namespace {

using render::Vec3d;

Vec3d vec(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

using Uvs = std::vector<std::array<float, 2>>;
using Face = std::array<std::uint32_t, 3>;

const Uvs& uvs_of(const scene::Mesh& mesh, std::size_t set) {
  return set == 0 ? mesh.uvs : mesh.uvs1;
}

std::array<double, 2> uv_edge(const Uvs& uvs, const Face& face, std::size_t to) {
  return {double{uvs[face[to]][0]} - double{uvs[face[0]][0]},
          double{uvs[face[to]][1]} - double{uvs[face[0]][1]}};
}
/// Of the face in the picture, twice. v runs down, so one that shows it as it is turns against the
/// corners' order: its area is negative.
double uv_area(const Uvs& uvs, const Face& face) {
  const auto a = uv_edge(uvs, face, 1), b = uv_edge(uvs, face, 2);
  return a[0] * b[1] - a[1] * b[0];
}

/// What the faces about a vertex say.
struct Gathered {
  Vec3d sum;
  double angles = 0;
  bool mirrored = false;
};

double angle_between(const Vec3d& a, const Vec3d& b) {
  return render::fast::acos(dot(normalize(a), normalize(b)));
}

/// Of the greatest sum that opposite directions leave by rounding.
constexpr double least_agreement = 1e-6;

}  // namespace

void part_mirrored(scene::Mesh& mesh, std::size_t uv_set) {
  constexpr std::uint8_t upright = 1, mirrored = 2, both = 3;
  std::vector<std::uint8_t> uses(mesh.positions.size(), 0);
  for (const Face& face : mesh.triangles) {
    const double area = uv_area(uvs_of(mesh, uv_set), face);
    if (area == 0) continue;
    for (const std::uint32_t corner : face) uses[corner] |= area > 0 ? mirrored : upright;
  }
  std::vector<std::uint32_t> parted;
  std::vector<std::uint32_t> twins(uses.size(), 0);
  for (std::uint32_t vertex = 0; vertex < uses.size(); ++vertex) {
    if (uses[vertex] != both) continue;
    twins[vertex] = static_cast<std::uint32_t>(uses.size() + parted.size());
    parted.push_back(vertex);
  }
  if (parted.empty()) return;
  for (Face& face : mesh.triangles) {
    if (!(uv_area(uvs_of(mesh, uv_set), face) > 0)) continue;
    for (std::uint32_t& corner : face) {
      if (uses[corner] == both) corner = twins[corner];
    }
  }
  const auto append_twins = [&](auto& values) {
    if (values.empty()) return;
    values.reserve(values.size() + parted.size());
    for (const std::uint32_t vertex : parted) values.push_back(values[vertex]);
  };
  append_twins(mesh.positions);
  append_twins(mesh.normals);
  append_twins(mesh.uvs);
  append_twins(mesh.uvs1);
  append_twins(mesh.colors);
}

std::vector<std::array<float, 4>> tangents_of(const scene::Mesh& mesh, std::size_t uv_set) {
  const Uvs& uvs = uvs_of(mesh, uv_set);
  std::vector<Gathered> gathered(mesh.positions.size());
  for (const Face& face : mesh.triangles) {
    const double area = uv_area(uvs, face);
    if (area == 0) continue;
    const Vec3d a = vec(mesh.positions[face[0]]);
    const Vec3d edge1 = vec(mesh.positions[face[1]]) - a, edge2 = vec(mesh.positions[face[2]]) - a;
    const double turn = area < 0 ? -1 : 1;
    const Vec3d along_u =
        normalize(edge1 * uv_edge(uvs, face, 2)[1] - edge2 * uv_edge(uvs, face, 1)[1]) * turn;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3d at = vec(mesh.positions[face[i]]);
      const double angle = angle_between(vec(mesh.positions[face[(i + 1) % 3]]) - at,
                                         vec(mesh.positions[face[(i + 2) % 3]]) - at);
      const Vec3d n = normalize(vec(mesh.normals[face[i]]));
      Gathered& vertex = gathered[face[i]];
      vertex.sum += normalize(along_u - n * dot(n, along_u)) * angle;
      vertex.angles += angle;
      vertex.mirrored = area > 0;
    }
  }
  std::vector<std::array<float, 4>> out;
  out.reserve(gathered.size());
  for (const Gathered& vertex : gathered) {
    const bool agreed = length(vertex.sum) > least_agreement * vertex.angles;
    const render::Vec3 t = agreed ? to_float(normalize(vertex.sum)) : render::Vec3{};
    out.push_back({t.x, t.y, t.z, vertex.mirrored ? -1.0F : 1.0F});
  }
  return out;
}

}  // namespace tessera::worker
