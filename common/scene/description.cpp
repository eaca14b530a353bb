#include "common/scene/description.hpp"

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

}  // namespace tessera::scene
