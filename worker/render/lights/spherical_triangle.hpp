#pragma once
#include "worker/render/vec.hpp"

namespace tessera::render {

/// A triangle as seen from a point: its solid angle, and directions uniform in it. The angle by Van
/// Oosterom and Strackee, "The Solid Angle of a Plane Triangle", 1983; directions by Arvo,
/// "Stratified Sampling of Spherical Triangles", SIGGRAPH 1995. In double, and the inner angles
/// enter by sine and cosine alone.
class SphericalTriangle {
 public:
  /// Its corners, seen from the point at the origin; none of them there.
  SphericalTriangle(const Vec3d& a, const Vec3d& b, const Vec3d& c);

  /// In steradians, 0 … 2π; 0 from within its plane.
  [[nodiscard]] double solid_angle() const { return solid_angle_; }
  /// A unit direction. u, v in [0, 1).
  [[nodiscard]] Vec3d sample(double u, double v) const;

 private:
  Vec3d a_, b_, c_;  ///< unit
  double cos_alpha_ = 1, sin_alpha_ = 0;
  double solid_angle_ = 0;
};

}  // namespace tessera::render
