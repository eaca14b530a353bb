#include "worker/render/lights/spherical_rectangle.hpp"

#include "worker/render/fastmath.hpp"

namespace tessera::render {

template <class N>
BasicSphericalRectangle<N>::BasicSphericalRectangle(const Vector& corner, const Vector& edge_u,
                                                    const Vector& edge_v, N inverse_length_u,
                                                    N inverse_length_v)
    : x_(edge_u * inverse_length_u),
      y_(edge_v * inverse_length_v),
      z_(cross(edge_u, edge_v) * (inverse_length_u * inverse_length_v)) {
  z0_ = dot(corner, z_);
  const auto below = z0_ > 0.0;
  z_ = {select(below, -z_.x, z_.x), select(below, -z_.y, z_.y), select(below, -z_.z, z_.z)};
  z0_ = select(below, -z0_, z0_);
  x0_ = dot(corner, x_);
  y0_ = dot(corner, y_);
  const N width = dot(edge_u, x_), height = dot(edge_v, y_);
  x1_ = x0_ + width;
  y1_ = y0_ + height;

  // The inner angles. The planes through the origin and the edges at y0, x1, y1, x0 have the
  // normals (0, z0, −y0), (−z0, 0, x1), (0, −z0, y1), (z0, 0, −x0); of two neighbours, the cross
  // product's length is |z0| times the distance of their corner.
  const N z2 = z0_ * z0_, x02 = x0_ * x0_, x12 = x1_ * x1_, y02 = y0_ * y0_, y12 = y1_ * y1_;
  using Turn = BasicTurn<N>;
  const Turn g0 = {y0_ * x1_, -z0_ * square_root(x12 + y02 + z2)};
  const Turn g1 = {-x1_ * y1_, -z0_ * square_root(x12 + y12 + z2)};
  const Turn g2 = {x0_ * y1_, -z0_ * square_root(x02 + y12 + z2)};
  const Turn g3 = {-x0_ * y0_, -z0_ * square_root(x02 + y02 + z2)};
  at_x0_ = g2 * g3;
  // The angles' sum is the solid angle and one full turn.
  const Turn sum = g0 * g1 * at_x0_;
  const N angle = fast::finite_atan2(sum.sin, sum.cos);
  // Below 0 it is an angle beyond π, or one near 0 that is rounded. Beyond π is only what the
  // origin stands over, and what is larger than its distance.
  const auto wide = (x0_ < 0.0) & (x1_ > 0.0) & (y0_ < 0.0) & (y1_ > 0.0) & (width * height > z2);
  const N turned = select(wide | (angle < -1.0), angle + 2 * pi_d, N(0.0));
  // From within the plane it is 0, whatever came of the angles.
  solid_angle_ = select(z0_ < 0.0, select(angle >= 0.0, angle, turned), N(0.0));
}

template <class N>
typename BasicSphericalRectangle<N>::Sample BasicSphericalRectangle<N>::sample(N u, N v) const {
  const N z2 = z0_ * z0_;
  // Lengths of the normals at y0, y1 and, squared, x0; their product is that of at_x0.
  const N n0 = square_root(z2 + y0_ * y0_), n1 = square_root(z2 + y1_ * y1_);
  const N inverse = 1.0 / (n0 * n1 * (z2 + x0_ * x0_));
  // The paper's angle au is u·solid angle less the angles at x0.
  const auto [sin_part, cos_part] = fast::sincos(u * solid_angle_);
  using Turn = BasicTurn<N>;
  const auto [cos_a, sin_a] =
      Turn{cos_part, sin_part} * Turn{at_x0_.cos * inverse, -at_x0_.sin * inverse};
  // The paper's fu = f/sin a, cu = ±1/√(fu² + b0²) and x = −cu·z0/√(1 − cu²), in one step that
  // keeps its digits near |cu| = 1; f and s here are n0·n1 times as large.
  const N f = -cos_a * y0_ * n1 - y1_ * n0;
  const N s = z0_ * n1 * sin_a;
  const N root = square_root(greater(f * f - s * s, N(1e-300)));
  const N x = within(-z0_ * select(f < 0.0, -sin_a, sin_a) * (n0 * n1) / root, x0_, x1_);
  const N d2 = x * x + z2;
  const N h0 = y0_ / square_root(d2 + y0_ * y0_), h1 = y1_ / square_root(d2 + y1_ * y1_);
  // h is the direction's own y, and d/√(1 − h²) the distance.
  const N h = h0 + v * (h1 - h0);
  const N distance = square_root(d2 / greater(1.0 - h * h, N(0x1p-52)));
  const N inverse_distance = 1.0 / distance;
  return {x_ * (x * inverse_distance) + y_ * h + z_ * (z0_ * inverse_distance), distance};
}

template class BasicSphericalRectangle<double>;
template class BasicSphericalRectangle<WideDouble>;

}  // namespace tessera::render
