#include "worker/render/octahedral.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tessera::render {
namespace {

TEST(Octahedral, DirectionsComeBackWithinATenthOfAMilliradian) {
  double worst = 0;
  for (int i = 0; i < 200; ++i) {
    for (int k = 0; k < 200; ++k) {
      const double z = -1 + 2.0 * i / 199, angle = 2 * pi_d * k / 200;
      const double r = std::sqrt(std::max(0.0, 1 - z * z));
      const Vec3d unit{r * std::cos(angle), r * std::sin(angle), z};
      const Vec3d back = to_double(decode_octahedral(encode_octahedral(to_float(unit))));
      worst = std::max(worst, length(back - unit));
    }
  }
  EXPECT_LT(worst, 1e-4);
}

TEST(Octahedral, AxesAreExact) {
  for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{-1, 0, 0},
                           Vec3{0, -1, 0}, Vec3{0, 0, -1}}) {
    EXPECT_EQ(decode_octahedral(encode_octahedral(axis)), axis);
  }
}

TEST(Octahedral, NoDirectionGivesSomeUnitVector) {
  EXPECT_FLOAT_EQ(length(decode_octahedral(encode_octahedral({0, 0, 0}))), 1);
}

}  // namespace
}  // namespace tessera::render
