#pragma once
#include "worker/render/vec.hpp"
#include "worker/render/wide.hpp"

namespace tessera::render {

/// An angle as a point in its direction from the origin, at any distance. Angles are added by
/// multiplying.
template <class N>
struct BasicTurn {
  N cos, sin;

  friend BasicTurn operator*(const BasicTurn& a, const BasicTurn& b) {
    return {a.cos * b.cos - a.sin * b.sin, a.sin * b.cos + a.cos * b.sin};
  }
};

/// A rectangle as seen from a point: its solid angle, and points of it uniform by solid angle.
/// Ureña, Fajardo, King, "An Area-Preserving Parametrization for Spherical Rectangles", EGSR 2013.
/// In double, with the paper's four angles added as points of the plane and taken by one arc
/// tangent, which stays exact where arc cosines lose their digits. N is a number, or several side
/// by side.
template <class N>
class BasicSphericalRectangle {
 public:
  using Vector = Vector3<N>;
  /// All seen from the point at the origin: the corner, and two edges at right angles, with one
  /// over the length of each.
  BasicSphericalRectangle(const Vector& corner, const Vector& edge_u, const Vector& edge_v,
                          N inverse_length_u, N inverse_length_v);
  BasicSphericalRectangle(const Vector& corner, const Vector& edge_u, const Vector& edge_v)
      : BasicSphericalRectangle(corner, edge_u, edge_v, 1 / length(edge_u), 1 / length(edge_v)) {}

  /// In steradians, 0 … 2π; 0 from within its plane.
  [[nodiscard]] N solid_angle() const { return solid_angle_; }
  struct Sample {
    Vector wi;  ///< of unit length, as exactly as the edges are at right angles
    N distance;
  };
  /// A point of the rectangle, where its solid angle is not 0. u, v in [0, 1).
  [[nodiscard]] Sample sample(N u, N v) const;

 private:
  Vector x_, y_, z_;  ///< axes; z points away from the rectangle
  N x0_, y0_, z0_, x1_, y1_;
  BasicTurn<N> at_x0_{1, 0};  ///< the sum of the inner angles at x0; not of unit length
  N solid_angle_ = 0;
};
extern template class BasicSphericalRectangle<double>;
extern template class BasicSphericalRectangle<WideDouble>;
using SphericalRectangle = BasicSphericalRectangle<double>;

}  // namespace tessera::render
