#pragma once
#include "worker/render/vec.hpp"

namespace tessera::render {

/// A circle as seen from a point: its solid angle, and points of it uniform by solid angle. In
/// double.
class SphericalDisk {
 public:
  /// Seen from the point at the origin; `normal` is of unit length.
  SphericalDisk(const Vec3d& center, const Vec3d& normal, double radius);

  /// In steradians, 0 … 2π; 0 from within its plane.
  [[nodiscard]] double solid_angle() const;
  struct Sample {
    Vec3d wi;  ///< of unit length
    double distance;
  };
  /// A point of the disk. Gamito, "Solid Angle Sampling of Disk and Cylinder Lights", EGSR 2016:
  /// points of the square around it, of which one side is turned to the eye, until one lies within;
  /// at worst about two in three do. Only the first is that of `u`; from then on numbers are made
  /// of it. distance 0: none was found, which never happens but by rounding.
  [[nodiscard]] Sample sample(Vec2 u) const;

 private:
  Vec3d center_, normal_;
  double radius_;
  Vec3d aside_;             ///< from the foot of the eye in the disk's plane to the centre
  double height_, beside_;  ///< of the eye: over the plane, and from the axis
};

}  // namespace tessera::render
