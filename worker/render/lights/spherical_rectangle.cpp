#include "worker/render/lights/spherical_rectangle.hpp"

#include <algorithm>
#include <cmath>

#include "worker/render/fastmath.hpp"

namespace tessera::render {

SphericalRectangle::SphericalRectangle(const Vec3d& corner, const Vec3d& edge_u,
                                       const Vec3d& edge_v, double inverse_length_u,
                                       double inverse_length_v)
    : x_(edge_u * inverse_length_u),
      y_(edge_v * inverse_length_v),
      z_(cross(edge_u, edge_v) * (inverse_length_u * inverse_length_v)) {
  z0_ = dot(corner, z_);
  if (z0_ > 0) {
    z0_ = -z0_;
    z_ = -z_;
  }
  x0_ = dot(corner, x_);
  y0_ = dot(corner, y_);
  const double width = dot(edge_u, x_), height = dot(edge_v, y_);
  x1_ = x0_ + width;
  y1_ = y0_ + height;
  if (!(z0_ < 0)) return;

  // The inner angles. The planes through the origin and the edges at y0, x1, y1, x0 have the
  // normals (0, z0, −y0), (−z0, 0, x1), (0, −z0, y1), (z0, 0, −x0); of two neighbours, the cross
  // product's length is |z0| times the distance of their corner.
  const double z2 = z0_ * z0_, x02 = x0_ * x0_, x12 = x1_ * x1_, y02 = y0_ * y0_, y12 = y1_ * y1_;
  const Turn g0 = {y0_ * x1_, -z0_ * std::sqrt(x12 + y02 + z2)};
  const Turn g1 = {-x1_ * y1_, -z0_ * std::sqrt(x12 + y12 + z2)};
  const Turn g2 = {x0_ * y1_, -z0_ * std::sqrt(x02 + y12 + z2)};
  const Turn g3 = {-x0_ * y0_, -z0_ * std::sqrt(x02 + y02 + z2)};
  at_x0_ = g2 * g3;
  // The angles' sum is the solid angle and one full turn.
  const Turn sum = g0 * g1 * at_x0_;
  const double angle = fast::atan2(sum.sin, sum.cos);
  // Below 0 it is an angle beyond π, or one near 0 that is rounded. Beyond π is only what the
  // origin stands over, and what is larger than its distance.
  const bool wide = x0_ < 0 && x1_ > 0 && y0_ < 0 && y1_ > 0 && width * height > z2;
  solid_angle_ = angle >= 0 ? angle : (wide || angle < -1 ? angle + 2 * pi_d : 0);
}

SphericalRectangle::Sample SphericalRectangle::sample(double u, double v) const {
  const double z2 = z0_ * z0_;
  // Lengths of the normals at y0, y1 and, squared, x0; their product is that of at_x0.
  const double n0 = std::sqrt(z2 + y0_ * y0_), n1 = std::sqrt(z2 + y1_ * y1_);
  const double inverse = 1 / (n0 * n1 * (z2 + x0_ * x0_));
  // The paper's angle au is u·solid angle less the angles at x0.
  const auto [sin_part, cos_part] = fast::sincos(u * solid_angle_);
  const auto [cos_a, sin_a] =
      Turn{cos_part, sin_part} * Turn{at_x0_.cos * inverse, -at_x0_.sin * inverse};
  // The paper's fu = f/sin a, cu = ±1/√(fu² + b0²) and x = −cu·z0/√(1 − cu²), in one step that
  // keeps its digits near |cu| = 1; f and s here are n0·n1 times as large.
  const double f = -cos_a * y0_ * n1 - y1_ * n0;
  const double s = z0_ * n1 * sin_a;
  const double root = std::sqrt(std::max(f * f - s * s, 1e-300));
  const double x = std::clamp(-z0_ * (f < 0 ? -sin_a : sin_a) * (n0 * n1) / root, x0_, x1_);
  const double d2 = x * x + z2;
  const double h0 = y0_ / std::sqrt(d2 + y0_ * y0_), h1 = y1_ / std::sqrt(d2 + y1_ * y1_);
  // h is the direction's own y, and d/√(1 − h²) the distance.
  const double h = h0 + v * (h1 - h0);
  const double distance = std::sqrt(d2 / std::max(1 - h * h, 0x1p-52));
  const double inverse_distance = 1 / distance;
  return {.wi = x_ * (x * inverse_distance) + y_ * h + z_ * (z0_ * inverse_distance),
          .distance = distance};
}

}  // namespace tessera::render
