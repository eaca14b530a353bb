#pragma once
#include <cmath>

#include "worker/render/vec.hpp"

namespace tessera::render {

/// A right-handed orthonormal basis; local z is `n`.
template <class T>
struct BasicFrame {
  Vector3<T> s{1, 0, 0}, t{0, 1, 0}, n{0, 0, 1};

  BasicFrame() = default;
  BasicFrame(const Vector3<T>& s_axis, const Vector3<T>& t_axis, const Vector3<T>& n_axis)
      : s(s_axis), t(t_axis), n(n_axis) {}
  /// Around a unit normal, without branches on where it points. Duff et al., "Building an
  /// Orthonormal Basis, Revisited", JCGT 6(1), 2017.
  explicit BasicFrame(const Vector3<T>& unit_normal) : n(unit_normal) {
    const T sign = std::copysign(T(1), n.z);
    const T a = T(-1) / (sign + n.z);
    const T b = n.x * n.y * a;
    s = {T(1) + sign * n.x * n.x * a, sign * b, -sign * n.x};
    t = {b, sign + n.y * n.y * a, -n.y};
  }

  [[nodiscard]] Vector3<T> to_local(const Vector3<T>& v) const {
    return {dot(v, s), dot(v, t), dot(v, n)};
  }
  [[nodiscard]] Vector3<T> to_world(const Vector3<T>& v) const {
    return s * v.x + t * v.y + n * v.z;
  }
};
using Frame = BasicFrame<float>;
using FrameD = BasicFrame<double>;

}  // namespace tessera::render
