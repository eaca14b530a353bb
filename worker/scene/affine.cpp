#include "worker/scene/affine.hpp"

#include <algorithm>
#include <cmath>

namespace tessera::worker {

using render::Vec3d;

Matrix3 linear(const scene::Transform& t) {
  return {t.m[0], t.m[1], t.m[2], t.m[4], t.m[5], t.m[6], t.m[8], t.m[9], t.m[10]};
}

double determinant(const Matrix3& m) {
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
         m[2] * (m[3] * m[7] - m[4] * m[6]);
}

std::optional<Matrix3> inverse(const Matrix3& m) {
  const double d = determinant(m);
  if (!std::isnormal(d)) return std::nullopt;
  const Matrix3 adjugate{
      m[4] * m[8] - m[5] * m[7], m[2] * m[7] - m[1] * m[8], m[1] * m[5] - m[2] * m[4],
      m[5] * m[6] - m[3] * m[8], m[0] * m[8] - m[2] * m[6], m[2] * m[3] - m[0] * m[5],
      m[3] * m[7] - m[4] * m[6], m[1] * m[6] - m[0] * m[7], m[0] * m[4] - m[1] * m[3]};
  Matrix3 out;
  for (std::size_t i = 0; i < 9; ++i) {
    out[i] = adjugate[i] / d;
    if (!std::isfinite(out[i])) return std::nullopt;
  }
  return out;
}

Vec3d times(const Matrix3& m, const Vec3d& v) {
  return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
          m[6] * v.x + m[7] * v.y + m[8] * v.z};
}

Vec3d times_transposed(const Matrix3& m, const Vec3d& v) {
  return {m[0] * v.x + m[3] * v.y + m[6] * v.z, m[1] * v.x + m[4] * v.y + m[7] * v.z,
          m[2] * v.x + m[5] * v.y + m[8] * v.z};
}

Vec3d times_point(const scene::Transform& t, const Vec3d& p) {
  return times(linear(t), p) + Vec3d{t.m[3], t.m[7], t.m[11]};
}

scene::Transform relative_to(const scene::Transform& t, const std::array<double, 3>& origin) {
  scene::Transform out = t;
  for (std::size_t axis = 0; axis < 3; ++axis) out.m[4 * axis + 3] -= origin[axis];
  return out;
}

scene::Transform from_origin(const scene::Transform& t, const std::array<double, 3>& origin) {
  const Vec3d shift = times_point(t, {origin[0], origin[1], origin[2]});
  scene::Transform out = t;
  out.m[3] = shift.x;
  out.m[7] = shift.y;
  out.m[11] = shift.z;
  return out;
}

double error_growth(const Matrix3& m, const Matrix3& inverse_of_m) {
  double most = 1;
  for (std::size_t row = 0; row < 3; ++row) {
    double sum = 0;
    for (std::size_t column = 0; column < 3; ++column) {
      for (std::size_t k = 0; k < 3; ++k) {
        sum += std::abs(m[3 * row + k]) * std::abs(inverse_of_m[3 * k + column]);
      }
    }
    most = std::max(most, sum);
  }
  return most;
}

accel::Affine rounded(const scene::Transform& t) {
  accel::Affine out;
  for (std::size_t i = 0; i < 12; ++i) out[i] = static_cast<float>(t.m[i]);
  return out;
}

}  // namespace tessera::worker
