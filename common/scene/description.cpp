#include "common/scene/description.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace tessera::scene {

Transform operator*(const Transform& a, const Transform& b) {
  Transform out;
  for (std::size_t row = 0; row < 3; ++row) {
    const double* left = &a.m[row * 4];
    for (std::size_t column = 0; column < 4; ++column) {
      double sum = left[0] * b.m[column] + left[1] * b.m[4 + column] + left[2] * b.m[8 + column];
      if (column == 3) sum += left[3];
      out.m[row * 4 + column] = sum;
    }
  }
  return out;
}

std::optional<double> uniform_scale(const Transform& t) {
  const auto product = [&](std::size_t a, std::size_t b) {
    return t.m[a] * t.m[b] + t.m[4 + a] * t.m[4 + b] + t.m[8 + a] * t.m[8 + b];
  };
  const double square = product(0, 0);
  constexpr double tolerance = 1e-9;
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = a; b < 3; ++b)
      if (!(std::abs(product(a, b) - (a == b ? square : 0)) <= tolerance * square))
        return std::nullopt;
  return std::sqrt(square);
}

Visibility operator&(const Visibility& a, const Visibility& b) {
  return {.camera = a.camera && b.camera,
          .shadow = a.shadow && b.shadow,
          .indirect = a.indirect && b.indirect,
          .holdout = a.holdout || b.holdout,
          .shadow_catcher = a.shadow_catcher || b.shadow_catcher};
}

Quad square_around(const Disk& disk) {
  const double size = std::hypot(disk.normal[0], disk.normal[1], disk.normal[2]);
  const Vec3 n{disk.normal[0] / size, disk.normal[1] / size, disk.normal[2] / size};
  // Across is up × n; a disk that faces straight up or down has +x to its right.
  const double level = std::hypot(n[0], n[2]);
  const Vec3 across = level > 1e-9 ? Vec3{n[2] / level, 0, -n[0] / level} : Vec3{1, 0, 0};
  const Vec3 along{n[1] * across[2] - n[2] * across[1], n[2] * across[0] - n[0] * across[2],
                   n[0] * across[1] - n[1] * across[0]};
  Quad out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.edge_u[axis] = 2 * disk.radius * across[axis];
    out.edge_v[axis] = 2 * disk.radius * along[axis];
    out.corner[axis] = disk.center[axis] - (across[axis] + along[axis]) * disk.radius;
  }
  return out;
}

bool is_singular(const Transform& t) {
  const auto& m = t.m;
  // The determinant is measured against the product of the rows' lengths (Hadamard's bound), so
  // that small scales are not taken for flat ones.
  double bound = 1;
  for (std::size_t row = 0; row < 12; row += 4)
    bound *= std::sqrt(m[row] * m[row] + m[row + 1] * m[row + 1] + m[row + 2] * m[row + 2]);
  const double determinant = m[0] * (m[5] * m[10] - m[6] * m[9]) -
                             m[1] * (m[4] * m[10] - m[6] * m[8]) +
                             m[2] * (m[4] * m[9] - m[5] * m[8]);
  const bool finite = std::all_of(m.begin(), m.end(), [](double x) { return std::isfinite(x); });
  return !finite || !std::isnormal(determinant) || !std::isfinite(bound) ||
         !(std::abs(determinant) > 1e-12 * bound);
}

}  // namespace tessera::scene
