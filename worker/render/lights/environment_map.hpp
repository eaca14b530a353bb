#pragma once
#include "worker/render/lights/cell_density.hpp"
#include "worker/render/textures/pyramid.hpp"
#include "worker/render/vec.hpp"

namespace tessera::render {

/// A picture of all that is infinitely far, and directions drawn by what comes from there.
/// Direction (x, y, z) shows the point u = ½ − atan2(−z, x)/2π from the picture's left and
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
    Color radiance;  ///< along it
    double pdf = 0;  ///< per solid angle
  };
  /// Drawn by how much brighter than the mean it is there: what is left, directions drawn from
  /// BSDFs find, and with multiple importance sampling the two together come nearer to the light
  /// than one that follows all of it (Karlík, Šik, Vévoda, Skřivan, Křivánek, "MIS Compensation:
  /// Optimizing Sampling Techniques in Multiple Importance Sampling", 2019). Where the picture is
  /// no brighter than its mean nothing is drawn, so this is for estimators alone that find light by
  /// BSDFs too and weigh it by pdf(). pdf 0 where the picture is black.
  [[nodiscard]] Drawn sample(Vec2 u) const;
  /// With which sample() gives a unit direction.
  [[nodiscard]] double pdf(const Vec3d& direction) const;
  /// In proportion to all that comes: for estimators that find this light in no other way.
  [[nodiscard]] Drawn sample_all(Vec2 u) const;
  [[nodiscard]] double pdf_all(const Vec3d& direction) const;

  /// The mean over all directions.
  [[nodiscard]] const Color& mean() const { return mean_; }

 private:
  [[nodiscard]] Color radiance_at(const CellDensity::Point& point) const;
  /// A place of the picture, 0 ≤ x, y ≤ 1.
  [[nodiscard]] CellDensity::Point point_of(const Vec3d& direction) const;
  [[nodiscard]] double pdf_by(const CellDensity& cells, const Vec3d& direction) const;
  [[nodiscard]] Drawn sample_by(const CellDensity& cells, Vec2 u) const;
  void take_mean();
  void weigh();

  Pyramid picture_;
  double turn_;  ///< in turns
  CellDensity plain_, compensated_;
  Color mean_;
};

}  // namespace tessera::render
