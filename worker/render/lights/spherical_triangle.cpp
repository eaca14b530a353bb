#include "worker/render/lights/spherical_triangle.hpp"

#include <algorithm>
#include <cmath>

#include "worker/render/fastmath.hpp"

namespace tessera::render {

SphericalTriangle::SphericalTriangle(const Vec3d& a, const Vec3d& b, const Vec3d& c)
    : a_(normalize(a)), b_(normalize(b)), c_(normalize(c)) {
  // The volume by the edges, not the corners: from far away the corners are nearly parallel.
  const double volume = std::abs(dot(a, cross(b - a, c - a))) / (length(a) * length(b) * length(c));
  const double angle = 2 * fast::atan2(volume, 1 + dot(a_, b_) + dot(b_, c_) + dot(c_, a_));
  const Vec3d ab = cross(a_, b_), ac = cross(a_, c_);
  const double y = std::abs(dot(ab, c_)), x = dot(ab, ac);
  const double r = std::sqrt(x * x + y * y);
  if (!(r > 0) || !(volume > 0)) return;
  solid_angle_ = angle;
  cos_alpha_ = x / r;
  sin_alpha_ = y / r;
}

Vec3d SphericalTriangle::sample(double u, double v) const {
  // The sub-triangle (a, b, c') of the fraction u of the solid angle; c' lies on the arc from a to
  // c.
  const auto [sin_area, cos_area] = fast::sincos(u * solid_angle_);
  const double s = sin_area * cos_alpha_ - cos_area * sin_alpha_;
  const double t = cos_area * cos_alpha_ + sin_area * sin_alpha_;
  const double p = t - cos_alpha_;
  const double q = s + sin_alpha_ * dot(a_, b_);
  const double denominator = (q * s + p * t) * sin_alpha_;
  const double cos_b = denominator == 0 ? 1 : ((q * t - p * s) * cos_alpha_ - q) / denominator;
  const double cos_arc = std::clamp(cos_b, dot(a_, c_), 1.0);
  const Vec3d across = normalize(c_ - a_ * dot(c_, a_));
  const Vec3d c_new =
      a_ * cos_arc + across * std::sqrt(std::max(0.0, (1 - cos_arc) * (1 + cos_arc)));
  // A point of the arc from b to c', by its height. 1 − cosines, as chords: they keep their digits.
  const double height = v * 0.5 * length_squared(c_new - b_);
  const Vec3d towards = normalize(c_new - b_ * dot(c_new, b_));
  return normalize(b_ * (1 - height) + towards * std::sqrt(std::max(0.0, height * (2 - height))));
}

}  // namespace tessera::render
