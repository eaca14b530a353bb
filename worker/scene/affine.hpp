#pragma once
#include <array>
#include <optional>

#include "common/scene/description.hpp"
#include "worker/accel/accel.hpp"
#include "worker/render/vec.hpp"

/// Transforms in double, before anything is rounded.
namespace tessera::worker {

using Matrix3 = std::array<double, 9>;  ///< row-major

/// The part that turns and scales.
Matrix3 linear(const scene::Transform& t);
double determinant(const Matrix3& m);
/// Nothing if the matrix is singular or not finite.
std::optional<Matrix3> inverse(const Matrix3& m);
render::Vec3d times(const Matrix3& m, const render::Vec3d& v);
render::Vec3d times_transposed(const Matrix3& m, const render::Vec3d& v);
render::Vec3d times_point(const scene::Transform& t, const render::Vec3d& p);

/// `t` and then minus `origin`.
scene::Transform relative_to(const scene::Transform& t, const std::array<double, 3>& origin);
/// `t` of what was moved by minus `origin`: puts it where `t` alone would have.
scene::Transform from_origin(const scene::Transform& t, const std::array<double, 3>& origin);
/// How much going there and back enlarges rounding errors: the greatest row sum of |M|·|M⁻¹|, at
/// least 1.
double error_growth(const Matrix3& m, const Matrix3& inverse_of_m);
accel::Affine rounded(const scene::Transform& t);

}  // namespace tessera::worker
