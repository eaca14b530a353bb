#pragma once
#include <cstdint>
#include <vector>

#include "worker/render/textures/pyramid.hpp"
#include "worker/render/vec.hpp"

namespace tessera::render {

/// A picture of all that is infinitely far, and directions drawn in proportion to what comes from
/// there. Direction (x, y, z) shows the point u = ½ − atan2(−z, x)/2π from the picture's left and
/// v = acos(y)/π from its top, after the surroundings are turned about +y. Between texels it is
/// bilinear.
class EnvironmentMap {
 public:
  /// `turn`: radians, counter-clockwise as seen from above.
  EnvironmentMap(image::Texels&& picture, scene::ColorSpace space, double turn);

  /// Along a unit direction.
  [[nodiscard]] Color radiance(const Vec3d& direction) const;

  struct Drawn {
    Vec3d direction;
    double pdf = 0;  ///< per solid angle
  };
  /// pdf 0 where the picture is black.
  [[nodiscard]] Drawn sample(Vec2 u) const;
  /// With which sample() gives a unit direction.
  [[nodiscard]] double pdf(const Vec3d& direction) const;

  /// The mean over all directions.
  [[nodiscard]] const Color& mean() const { return mean_; }

 private:
  /// A point of the picture, 0 ≤ x, y ≤ 1.
  struct Point {
    double x, y;
  };
  [[nodiscard]] Point point_of(const Vec3d& direction) const;
  void weigh();

  Pyramid picture_;
  double turn_;  ///< in turns
  /// Cells in which the density is constant over the picture; each holds whole texels. What is
  /// kept of them are running sums, row by row and over the rows.
  int columns_ = 0, rows_ = 0;
  std::vector<float> in_row_;   ///< rows of columns_ + 1, each from 0 to 1
  std::vector<float> of_rows_;  ///< rows_ + 1, from 0 to 1
  Color mean_;
};

}  // namespace tessera::render
