#include "worker/scene/parallelogram.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace tessera::worker {
namespace {

render::Geometry mesh(const std::vector<accel::Point>& positions,
                      const std::vector<accel::Triangle>& triangles) {
  render::Geometry out;
  out.positions = accel::Buffer<accel::Point>(positions.size());
  out.triangles = accel::Buffer<accel::Triangle>(triangles.size());
  for (std::size_t i = 0; i < positions.size(); ++i) out.positions[i] = positions[i];
  for (std::size_t i = 0; i < triangles.size(); ++i) out.triangles[i] = triangles[i];
  return out;
}

accel::Triangle turned(const accel::Triangle& t, std::uint32_t by) {
  return {t[by % 3], t[(by + 1) % 3], t[(by + 2) % 3]};
}

/// A sheared quad, 0 1 2 3 in order; 4 and 5 stand where 0 and 2 do.
const std::vector<accel::Point> corners = {{0, 0, 1}, {3, 0, 1}, {4, 2, 1},
                                           {1, 2, 1}, {0, 0, 1}, {4, 2, 1}};

TEST(Parallelogram, IsFoundWhicheverCornersItsHalvesBeginWith) {
  for (std::uint32_t i = 0; i < 3; ++i) {
    for (std::uint32_t j = 0; j < 3; ++j) {
      const auto found =
          parallelogram(mesh(corners, {turned({0, 1, 2}, i), turned({0, 2, 3}, j)}), 0);
      ASSERT_TRUE(found) << i << ' ' << j;
      EXPECT_EQ(found->corner, 1U);
      EXPECT_EQ(found->end_u, 2U);
      EXPECT_EQ(found->end_v, 0U);
    }
  }
}

TEST(Parallelogram, IsFoundWhereItsHalvesShareNoVertexButPlaces) {
  EXPECT_TRUE(parallelogram(mesh(corners, {{0, 1, 2}, {4, 5, 3}}), 0));
}

TEST(Parallelogram, IsNotWhatLooksTwoWays) {
  EXPECT_FALSE(parallelogram(mesh(corners, {{0, 1, 2}, {0, 3, 2}}), 0));
}

TEST(Parallelogram, IsOfAFaceAndTheNextAlone) {
  const render::Geometry three = mesh(corners, {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}});
  EXPECT_FALSE(parallelogram(three, 0));
  EXPECT_FALSE(parallelogram(three, 2));
}

TEST(Parallelogram, IsNotAKite) {
  EXPECT_FALSE(parallelogram(
      mesh({{0, 0, 0}, {1, -1, 0}, {3, 0, 0}, {1, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}), 0));
}

TEST(Parallelogram, ForgivesNoMoreThanRounding) {
  // At coordinates of some thousand a float's step is 2⁻¹¹ or less: 2⁻²¹ of 5,000 are 4.9 of them.
  const auto with = [](float off) {
    return mesh({{5000, 0, 0}, {5003, 0, 0}, {5004, 2, 0}, {5001 + off, 2, 0}},
                {{0, 1, 2}, {0, 2, 3}});
  };
  EXPECT_TRUE(parallelogram(with(0x1p-11F), 0));
  EXPECT_FALSE(parallelogram(with(0x1p-7F), 0));
  // Where edges are no longer than that, it would forgive any shape.
  EXPECT_FALSE(parallelogram(
      mesh({{5000, 0, 0}, {5000.0010F, 0, 0}, {5000.0010F, 0x1p-10F, 0}, {4999.9995F, 0x1p-10F, 0}},
           {{0, 1, 2}, {0, 2, 3}}),
      0));
}

TEST(Parallelogram, ForgivesTheRoundingOfWhereItCameFrom) {
  // The same, moved to the origin when it was built: what its file's floats were off stays.
  const render::Geometry moved =
      mesh({{0, 0, 0}, {3, 0, 0}, {4, 2, 0}, {1 + 0x1p-11F, 2, 0}}, {{0, 1, 2}, {0, 2, 3}});
  EXPECT_FALSE(parallelogram(moved, 0));
  const auto found = parallelogram(moved, 0, {5000, 0, 0});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->across, 3U);
}

TEST(Parallelogram, IsNotWithoutArea) {
  EXPECT_FALSE(
      parallelogram(mesh({{0, 0, 0}, {1, 0, 0}, {3, 0, 0}, {2, 0, 0}}, {{0, 1, 2}, {0, 2, 3}}), 0));
}

}  // namespace
}  // namespace tessera::worker
