#include "worker/render/lights/spherical_rectangle.hpp"

#include <algorithm>
#include <cmath>

#include "worker/render/fastmath.hpp"

namespace tessera::render {

namespace {

/// An angle as the point at it on the unit circle. Angles are added by multiplying.
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

/// The inner angle between the planes of two neighbouring edges, whose unit normals are (0,
/// other_a, z_a) and (other_b, 0, z_b).
Turn inner_angle(double z_a, double other_a, double z_b, double other_b) {
  return {-z_a * z_b, std::sqrt(other_a * other_a + z_a * z_a * other_b * other_b)};
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

  // Normals of the planes through the origin and each edge: y = y0, x = x1, y = y1, x = x0.
  const double l0 = 1 / std::sqrt(z0_ * z0_ + y0_ * y0_), l1 = 1 / std::sqrt(z0_ * z0_ + x1_ * x1_);
  const double l2 = 1 / std::sqrt(z0_ * z0_ + y1_ * y1_), l3 = 1 / std::sqrt(z0_ * z0_ + x0_ * x0_);
  const double n0 = -y0_ * l0, n1 = x1_ * l1, n2 = y1_ * l2, n3 = -x0_ * l3;
  const Turn g0 = inner_angle(n0, z0_ * l0, n1, z0_ * l1);
  const Turn g1 = inner_angle(n2, z0_ * l2, n1, z0_ * l1);
  const Turn g2 = inner_angle(n2, z0_ * l2, n3, z0_ * l3);
  const Turn g3 = inner_angle(n0, z0_ * l0, n3, z0_ * l3);
  k_ = 2 * pi_d - angle_of(g2 * g3);
  solid_angle_ = std::max(0.0, angle_of(g0 * g1) - k_);
  b0_ = n0;
  b1_ = n2;
}

Vec3d SphericalRectangle::sample(double u, double v) const {
  const auto [sin_a, cos_a] = fast::sincos(u * solid_angle_ + k_);
  const double f = (cos_a * b0_ - b1_) / sin_a;
  // The paper's cu = ±1/√(f² + b0²) and x = −cu·z0/√(1 − cu²), in one step that keeps its digits
  // near |cu| = 1.
  const double g = std::sqrt(std::max(f * f + b0_ * b0_ - 1, 1e-300));
  const double x = std::clamp(std::copysign(-z0_ / g, f), x0_, x1_);
  const double d2 = x * x + z0_ * z0_;
  const double h0 = y0_ / std::sqrt(d2 + y0_ * y0_), h1 = y1_ / std::sqrt(d2 + y1_ * y1_);
  const double h = h0 + v * (h1 - h0);
  const double y = std::clamp(h * std::sqrt(d2 / std::max(1 - h * h, 1e-300)), y0_, y1_);
  return x_ * x + y_ * y + z_ * z0_;
}

}  // namespace tessera::render
