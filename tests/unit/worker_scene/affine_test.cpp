#include "worker/scene/affine.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tessera::worker {
namespace {

const scene::Transform skewed{{2, 0.5, 0, 10, 0, 1, 0.25, -3, 0.1, 0, -4, 7}};

TEST(Affine, TheInverseUndoes) {
  const auto back = inverse(linear(skewed));
  ASSERT_TRUE(back);
  const render::Vec3d v{1, -2, 3};
  const render::Vec3d there_and_back = times(*back, times(linear(skewed), v));
  EXPECT_NEAR(there_and_back.x, v.x, 1e-14);
  EXPECT_NEAR(there_and_back.y, v.y, 1e-14);
  EXPECT_NEAR(there_and_back.z, v.z, 1e-14);
}

TEST(Affine, ASingularMatrixHasNoInverse) {
  EXPECT_FALSE(inverse({1, 2, 3, 2, 4, 6, 0, 0, 1}));
  EXPECT_FALSE(inverse({1, 0, 0, 0, NAN, 0, 0, 0, 1}));
}

TEST(Affine, OnlySimilaritiesHaveAUniformScale) {
  const double c = std::cos(0.7), s = std::sin(0.7);
  const auto scaled =
      scene::uniform_scale({{3 * c, -3 * s, 0, 5, 3 * s, 3 * c, 0, 6, 0, 0, -3, 7}});
  ASSERT_TRUE(scaled);
  EXPECT_NEAR(*scaled, 3, 1e-12);
  EXPECT_FALSE(scene::uniform_scale(skewed));
  EXPECT_FALSE(scene::uniform_scale({{1, 0, 0, 0, 0, 1.001, 0, 0, 0, 0, 1, 0}}));
}

TEST(Affine, WhatWasMovedByMinusAnOriginIsPutWhereItWouldHaveBeen) {
  const std::array<double, 3> origin{1e9, -5, 2e8};
  const render::Vec3d p{0.25, 3, -1};
  const render::Vec3d plain = times_point(skewed, p + render::Vec3d{1e9, -5, 2e8});
  const render::Vec3d moved = times_point(from_origin(skewed, origin), p);
  EXPECT_NEAR(moved.x, plain.x, 1e-5);
  EXPECT_NEAR(moved.y, plain.y, 1e-5);
  EXPECT_NEAR(moved.z, plain.z, 1e-5);
  EXPECT_EQ(from_origin(skewed, {}).m, skewed.m);
}

TEST(Affine, ErrorGrowthIsOneForTurnsOfAxesAndLargeForFlatThings) {
  const Matrix3 flat{1, 0, 0, 0, 1e-3, 1, 0, 0, 1};
  EXPECT_DOUBLE_EQ(
      error_growth({0, 2, 0, -2, 0, 0, 0, 0, 2}, *inverse({0, 2, 0, -2, 0, 0, 0, 0, 2})), 1);
  EXPECT_GE(error_growth(flat, *inverse(flat)), 2);
}

}  // namespace
}  // namespace tessera::worker
