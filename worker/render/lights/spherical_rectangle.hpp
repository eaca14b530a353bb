#pragma once
#include "worker/render/vec.hpp"

namespace tessera::render {

/// An angle as a point in its direction from the origin, at any distance. Angles are added by
/// multiplying.
struct Turn {
  double cos, sin;

  friend Turn operator*(const Turn& a, const Turn& b) {
    return {a.cos * b.cos - a.sin * b.sin, a.sin * b.cos + a.cos * b.sin};
  }
};

/// A rectangle as seen from a point: its solid angle, and points of it uniform by solid angle.
/// Ureña, Fajardo, King, "An Area-Preserving Parametrization for Spherical Rectangles", EGSR 2013.
/// In double, with the paper's four angles added as points of the plane and taken by one arc
/// tangent, which stays exact where arc cosines lose their digits.
class SphericalRectangle {
 public:
  /// All seen from the point at the origin: the corner, and two edges at right angles, with one
  /// over the length of each.
  SphericalRectangle(const Vec3d& corner, const Vec3d& edge_u, const Vec3d& edge_v,
                     double inverse_length_u, double inverse_length_v);
  SphericalRectangle(const Vec3d& corner, const Vec3d& edge_u, const Vec3d& edge_v)
      : SphericalRectangle(corner, edge_u, edge_v, 1 / length(edge_u), 1 / length(edge_v)) {}

  /// In steradians, 0 … 2π; 0 from within its plane.
  [[nodiscard]] double solid_angle() const { return solid_angle_; }
  struct Sample {
    Vec3d wi;  ///< of unit length, as exactly as the edges are at right angles
    double distance;
  };
  /// A point of the rectangle. u, v in [0, 1).
  [[nodiscard]] Sample sample(double u, double v) const;

 private:
  Vec3d x_, y_, z_;  ///< axes; z points away from the rectangle
  double x0_, y0_, z0_, x1_, y1_;
  Turn at_x0_{1, 0};  ///< the sum of the inner angles at x0; not of unit length
  double solid_angle_ = 0;
};

}  // namespace tessera::render
