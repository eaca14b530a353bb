#include "worker/render/lights/spherical_rectangle.hpp"

#include <algorithm>
#include <cmath>

#include "worker/render/fastmath.hpp"

namespace tessera::render {

namespace {

/// An angle as a point in its direction from the origin. Angles are added by multiplying.
struct Turn {
  double cos, sin;
};
Turn operator*(const Turn& a, const Turn& b) {
  return {a.cos * b.cos - a.sin * b.sin, a.sin * b.cos + a.cos * b.sin};
}
/// In 0 … 2π: for a sum of two angles between 0 and π.
double angle_of(const Turn& turn) {
  const double angle = fast::atan2(turn.sin, turn.cos);
  return angle < 0 ? angle + 2 * pi_d : angle;
}

}  // namespace

SphericalRectangle::SphericalRectangle(const Vec3d& corner, const Vec3d& edge_u,
                                       const Vec3d& edge_v) {
  const double length_u = length(edge_u), length_v = length(edge_v);
  x_ = edge_u / length_u;
  y_ = edge_v / length_v;
  z_ = cross(x_, y_);
  z0_ = dot(corner, z_);
  if (z0_ > 0) {
    z0_ = -z0_;
    z_ = -z_;
  }
  x0_ = dot(corner, x_);
  y0_ = dot(corner, y_);
  x1_ = x0_ + length_u;
  y1_ = y0_ + length_v;
  if (!(z0_ < 0)) return;

  // The inner angles. The planes through the origin and the edges at y0, x1, y1, x0 have the
  // normals (0, z0, −y0), (−z0, 0, x1), (0, −z0, y1), (z0, 0, −x0); of two neighbours, the cross
  // product's length is |z0| times the distance of their corner.
  const double z2 = z0_ * z0_, x02 = x0_ * x0_, x12 = x1_ * x1_, y02 = y0_ * y0_, y12 = y1_ * y1_;
  const Turn g0 = {y0_ * x1_, -z0_ * std::sqrt(x12 + y02 + z2)};
  const Turn g1 = {-x1_ * y1_, -z0_ * std::sqrt(x12 + y12 + z2)};
  const Turn g2 = {x0_ * y1_, -z0_ * std::sqrt(x02 + y12 + z2)};
  const Turn g3 = {-x0_ * y0_, -z0_ * std::sqrt(x02 + y02 + z2)};
  k_ = 2 * pi_d - angle_of(g2 * g3);
  solid_angle_ = std::max(0.0, angle_of(g0 * g1) - k_);
}

Vec3d SphericalRectangle::sample(double u, double v) const {
  const auto [sin_a, cos_a] = fast::sincos(u * solid_angle_ + k_);
  const double z2 = z0_ * z0_;
  // Of the unit normals at y0 and y1, the paper's b0 and b1.
  const double l0 = 1 / std::sqrt(z2 + y0_ * y0_), l1 = 1 / std::sqrt(z2 + y1_ * y1_);
  const double f = -cos_a * y0_ * l0 - y1_ * l1;
  // The paper's fu = f/sin a, cu = ±1/√(fu² + b0²) and x = −cu·z0/√(1 − cu²), in one step that
  // keeps its digits near |cu| = 1.
  const double s = z0_ * l0 * sin_a;
  const double root = std::sqrt(std::max(f * f - s * s, 1e-300));
  const double x = std::clamp(-z0_ * (f < 0 ? -sin_a : sin_a) / root, x0_, x1_);
  const double d2 = x * x + z2;
  const double h0 = y0_ / std::sqrt(d2 + y0_ * y0_), h1 = y1_ / std::sqrt(d2 + y1_ * y1_);
  const double h = h0 + v * (h1 - h0);
  const double y = std::clamp(h * std::sqrt(d2 / std::max(1 - h * h, 1e-300)), y0_, y1_);
  return x_ * x + y_ * y + z_ * z0_;
}

}  // namespace tessera::render
