#pragma once
#include "worker/render/vec.hpp"

namespace tessera::render {

/// A rectangle as seen from a point: its solid angle, and points of it uniform by solid angle.
/// Ureña, Fajardo, King, "An Area-Preserving Parametrization for Spherical Rectangles", EGSR 2013.
/// In double, with the two angles that the paper sums taken as one arc tangent each, which stays
/// exact where arc cosines lose their digits.
class SphericalRectangle {
 public:
  /// All seen from the point at the origin: the corner, and two edges at right angles.
  SphericalRectangle(const Vec3d& corner, const Vec3d& edge_u, const Vec3d& edge_v);

  /// In steradians, 0 … 2π; 0 from within its plane.
  [[nodiscard]] double solid_angle() const { return solid_angle_; }
  /// The point of the rectangle, as seen from the origin (not normalised). u, v in [0, 1).
  [[nodiscard]] Vec3d sample(double u, double v) const;

 private:
  Vec3d x_, y_, z_;  ///< axes; z points away from the rectangle
  double x0_, y0_, z0_, x1_, y1_;
  double k_ = 0, solid_angle_ = 0;
};

}  // namespace tessera::render
