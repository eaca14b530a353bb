#pragma once
#include <cmath>

#include "worker/render/lights/shapes.hpp"

/// What flat lights have in common.
namespace tessera::render {

/// True if a lit point that is so far below a flat light sees it.
inline bool sees(bool two_sided, double below) { return two_sided ? below != 0 : below < 0; }

/// A plane as seen from the lit point.
struct Plane {
  Vec3d corner;  ///< a point of it
  Vec3d normal;  ///< its length is the parallelogram's area
  double below;  ///< of the lit point, along the normal: positive if it sees the back

  Plane(const Vec3d& corner_, const Vec3d& u, const Vec3d& v)
      : corner(corner_), normal(cross(u, v)), below(dot(corner_, normal)) {}

  [[nodiscard]] bool visible(bool two_sided) const { return sees(two_sided, below); }
  /// From a density uniform over `part` of the parallelogram to one per solid angle.
  [[nodiscard]] double pdf_by_area(double part, double distance, const Vec3d& wi) const {
    const double seen = std::abs(dot(wi, normal)) * part;
    return seen > 0 ? distance * distance / seen : 0;
  }
  [[nodiscard]] double distance_along(const Vec3d& wi) const { return below / dot(wi, normal); }
};

/// The sample that leads to `point`, seen from the lit one.
inline ShapeSample towards(const Vec3d& point, double pdf) {
  const double distance = length(point);
  return {.wi = point * (1 / distance), .distance = distance, .pdf = pdf};
}

}  // namespace tessera::render
