#include "worker/scene/parallelogram.hpp"

#include <algorithm>
#include <cmath>

namespace tessera::worker {
namespace {

using render::Vec3d;

Vec3d at(const accel::Point& p) { return {p[0], p[1], p[2]}; }

/// How far from where it should be the fourth corner may lie.
double tolerance(const Vec3d& corner, const Vec3d& u, const Vec3d& v,
                 const std::array<double, 3>& origin) {
  const Vec3d whence = corner + Vec3d{origin[0], origin[1], origin[2]};
  double largest = 0;
  for (const Vec3d& p : {whence, whence + u, whence + v}) {
    largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  }
  return std::min(largest * 0x1p-21, std::min(length(u), length(v)) * 0x1p-12);
}

}  // namespace

std::optional<Parallelogram> parallelogram(const render::Geometry& geometry, std::uint32_t face,
                                           const std::array<double, 3>& origin) {
  if (face + 1 >= geometry.triangles.size()) return std::nullopt;
  const auto& points = geometry.positions;
  const accel::Triangle& first = geometry.triangles[face];
  const accel::Triangle& second = geometry.triangles[face + 1];
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const Parallelogram found{first[i], first[(i + 1) % 3], first[(i + 2) % 3], second[j]};
      // Neighbours of one side go along their common edge in opposite directions.
      if (points[found.end_u] != points[second[(j + 2) % 3]] ||
          points[found.end_v] != points[second[(j + 1) % 3]]) {
        continue;
      }
      const Vec3d corner = at(points[found.corner]);
      const Vec3d u = at(points[found.end_u]) - corner, v = at(points[found.end_v]) - corner;
      const double off = length(at(points[found.across]) - (corner + u + v));
      if (length(cross(u, v)) > 0 && off <= tolerance(corner, u, v, origin)) return found;
    }
  }
  return std::nullopt;
}

}  // namespace tessera::worker
