#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/render/chi2.hpp"
#include "worker/render/lights/light.hpp"
#include "worker/render/lights/spherical_rectangle.hpp"
#include "worker/render/lights/spherical_triangle.hpp"

namespace tessera::render {
namespace {

/// Of a rectangle a × b, seen from the height h above a corner.
double corner_angle(double a, double b, double h) {
  return std::atan2(a * b, h * std::sqrt(a * a + b * b + h * h));
}

TEST(SolidAngle, OfARectangleOverItsCornerIsTheClosedForm) {
  for (const double a : {1e-3, 0.5, 1.0, 30.0}) {
    for (const double b : {2e-3, 0.7, 1.0, 1000.0}) {
      for (const double h : {1e-3, 0.1, 1.0, 50.0}) {
        const double expected = corner_angle(a, b, h);
        if (expected < 1e-6) continue;
        EXPECT_NEAR(SphericalRectangle({0, 0, h}, {a, 0, 0}, {0, b, 0}).solid_angle() / expected, 1,
                    1e-8)
            << a << ' ' << b << ' ' << h;
        EXPECT_NEAR(SphericalRectangle({-a, -b, -h}, {a, 0, 0}, {0, b, 0}).solid_angle() / expected,
                    1, 1e-8);
      }
    }
  }
}

TEST(SolidAngle, OfARectangleOffItsCornerIsADifferenceOfCorners) {
  // x from 2 to 3, y from 1 to 4, at height .5.
  const double expected = corner_angle(3, 4, 0.5) - corner_angle(2, 4, 0.5) -
                          corner_angle(3, 1, 0.5) + corner_angle(2, 1, 0.5);
  EXPECT_NEAR(SphericalRectangle({2, 1, 0.5}, {1, 0, 0}, {0, 3, 0}).solid_angle(), expected, 1e-12);
}

TEST(SolidAngle, OfAnOctantIsHalfPi) {
  EXPECT_NEAR(SphericalTriangle({2, 0, 0}, {0, 3, 0}, {0, 0, 5}).solid_angle(), M_PI / 2, 1e-14);
  // One side of a cube from its centre: a sixth of all.
  EXPECT_NEAR(SphericalRectangle({-1, -1, 1}, {2, 0, 0}, {0, 2, 0}).solid_angle(), 4 * M_PI / 6,
              1e-13);
}

TEST(SolidAngle, OfATriangleIsThatOfItsHalvedRectangles) {
  test::Random random(8);
  for (int i = 0; i < 1000; ++i) {
    const Vec3d corner = {random.next() * 4.0 - 2, random.next() * 4.0 - 2, random.next() + 0.05};
    const Vec3d u = {random.next() + 0.1, 0, 0}, v = {0, random.next() + 0.1, 0};
    const double rectangle = SphericalRectangle(corner, u, v).solid_angle();
    const double triangles =
        SphericalTriangle(corner, corner + u, corner + v).solid_angle() +
        SphericalTriangle(corner + u + v, corner + v, corner + u).solid_angle();
    EXPECT_NEAR(triangles / rectangle, 1, 1e-10);
  }
}

TEST(SolidAngle, TinyAndFarKeepTheirDigits) {
  const double far = 1e3;
  const double expected = 1 / (far * far);
  EXPECT_NEAR(
      SphericalTriangle({0, 0, far}, {1, 0, far}, {0, 1, far}).solid_angle() / (0.5 * expected), 1,
      1e-5);
  EXPECT_NEAR(SphericalTriangle({0, 0, 1e6}, {1, 0, 1e6}, {0, 1, 1e6}).solid_angle() / 0.5e-12, 1,
              1e-5);
}

TEST(SolidAngle, FromWithinThePlaneIsNothing) {
  EXPECT_EQ(SphericalRectangle({1, 1, 0}, {1, 0, 0}, {0, 1, 0}).solid_angle(), 0);
  EXPECT_EQ(SphericalTriangle({1, 1, 0}, {2, 1, 0}, {1, 2, 0}).solid_angle(), 0);
}

// Form factors of the facts, by light samples: the mean of cos θ / pdf over π, and its stratified
// error.
double form_factor(const Light& light, const Vec3& p, const Vec3& n) {
  constexpr int side = 400;
  double sum = 0;
  for (int i = 0; i < side * side; ++i) {
    const int row = i / side, column = i % side;
    const Vec2 u = {(static_cast<float>(row) + 0.5F) / side,
                    (static_cast<float>(column) + 0.5F) / side};
    const LightSample drawn = sample(light, {.p = p, .n = n}, u);
    if (drawn) sum += static_cast<double>(std::max(0.0F, dot(drawn.wi, n)) / drawn.pdf);
  }
  return sum / (side * side) / M_PI;
}

Light quad(const Vec3& corner, const Vec3& u, const Vec3& v) {
  return {.shape = QuadLight{corner, u, v}, .radiance = gray(1), .two_sided = true};
}
Light triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
  return {.shape = TriangleLight{a, b, c}, .radiance = gray(1), .two_sided = true};
}

/// The two triangles of a quad.
double form_factor_of_halves(const Vec3& corner, const Vec3& u, const Vec3& v, const Vec3& p,
                             const Vec3& n) {
  return form_factor(triangle(corner, corner + u, corner + v), p, n) +
         form_factor(triangle(corner + u + v, corner + v, corner + u), p, n);
}

TEST(FormFactor, OfAParallelRectangleOverItsCorner) {
  EXPECT_NEAR(form_factor(quad({0, 0, 1}, {1, 0, 0}, {0, 1, 0}), {}, {0, 0, 1}), 0.1385316, 2e-6);
  EXPECT_NEAR(form_factor_of_halves({0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {}, {0, 0, 1}), 0.1385316,
              2e-6);
}

TEST(FormFactor, OfACentredRectangle) {
  EXPECT_NEAR(form_factor(quad({-1, -1, 1}, {2, 0, 0}, {0, 2, 0}), {}, {0, 0, 1}), 0.5541264, 5e-6);
  EXPECT_NEAR(form_factor(quad({-.5F, -.5F, 1}, {1, 0, 0}, {0, 1, 0}), {}, {0, 0, 1}), 0.2394565,
              2e-6);
  EXPECT_NEAR(form_factor(quad({-.5F, -.5F, 2}, {1, 0, 0}, {0, 1, 0}), {}, {0, 0, 1}), 0.0734776,
              1e-6);
  EXPECT_NEAR(form_factor_of_halves({-1, -1, 1}, {2, 0, 0}, {0, 2, 0}, {}, {0, 0, 1}), 0.5541264,
              1e-5);
}

/// Facts, case 6, in its own words: a rectangle b wide and a high on a wall at the distance c,
/// resting on the element's plane. The element faces up and sees one corner of the rectangle's foot
/// straight ahead.
double perpendicular(float a, float b, float c) {
  return form_factor(quad({0, c, 0}, {b, 0, 0}, {0, 0, a}), {}, {0, 0, 1});
}

TEST(FormFactor, OfAPerpendicularRectangle) {
  EXPECT_NEAR(perpendicular(1, 1, 1), 0.0557342, 2e-6);
  EXPECT_NEAR(perpendicular(2, 1, 0.5F), 0.1587748, 4e-6);
}

TEST(FormFactor, OfASphereOverTheHorizon) {
  // Facts, case 8: (R/d)² cos θ.
  const Vec3 center = {0.9F, 0.2F, 1.4F};
  const Light light = {.shape = SphereLight{center, 0.7F}, .radiance = gray(1)};
  const double d = static_cast<double>(length(center));
  EXPECT_NEAR(form_factor(light, {}, {0, 0, 1}), 0.49 / (d * d) * (1.4 / d), 2e-6);
}

TEST(FormFactor, OfASlantedParallelogramIsThatOfItsHalves) {
  const Vec3 corner = {0.2F, -0.7F, 0.9F}, u = {1, 0.2F, 0.1F}, v = {0.7F, 1.3F, -0.3F};
  EXPECT_NEAR(form_factor(quad(corner, u, v), {}, {0, 0, 1}),
              form_factor_of_halves(corner, u, v, {}, {0, 0, 1}), 5e-6);
}

}  // namespace
}  // namespace tessera::render
