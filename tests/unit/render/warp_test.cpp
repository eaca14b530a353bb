#include "worker/render/warp.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/render/chi2.hpp"
#include "worker/render/frame.hpp"

namespace tessera::render {
namespace {

/// Directions into the square: (1 + cos θ)/2 and the azimuth.
Vec2 square_of(const Vec3& v) {
  const float azimuth = std::atan2(v.y, v.x) / (2 * pi);
  return {0.5F * (1 + v.z), azimuth < 0 ? azimuth + 1 : azimuth};
}
Vec3 direction_of(double s, double t) {
  const double z = 2 * s - 1, r = std::sqrt(std::max(0.0, 1 - z * z));
  return to_float(Vec3d{r * std::cos(2 * M_PI * t), r * std::sin(2 * M_PI * t), z});
}

template <class Warp, class Pdf>
test::Chi2Case directions(Warp warp, Pdf pdf) {
  test::Chi2Case test;
  test.sample = [warp](test::Random& random) {
    const Vec3 v = warp(random.next2());
    EXPECT_NEAR(length(v), 1, 1e-6F);
    return std::optional(square_of(v));
  };
  // The square's unit is 4π steradians.
  test.density = [pdf](double s, double t) {
    return 4 * M_PI * static_cast<double>(pdf(direction_of(s, t)));
  };
  return test;
}

TEST(Warp, CosineHemisphereFollowsItsDensity) {
  EXPECT_EQ(test::chi2_test(directions(square_to_cosine_hemisphere, cosine_hemisphere_pdf)), "");
}
TEST(Warp, HemisphereFollowsItsDensity) {
  EXPECT_EQ(test::chi2_test(directions(square_to_hemisphere, hemisphere_pdf)), "");
}
TEST(Warp, SphereFollowsItsDensity) {
  EXPECT_EQ(test::chi2_test(directions(square_to_sphere, [](const Vec3&) { return sphere_pdf(); })),
            "");
}

TEST(Warp, DiskFollowsItsDensity) {
  test::Chi2Case test;
  test.sample = [](test::Random& random) {
    const Vec2 d = square_to_disk(random.next2());
    const float azimuth = std::atan2(d.y, d.x) / (2 * pi);
    return std::optional(Vec2{d.x * d.x + d.y * d.y, azimuth < 0 ? azimuth + 1 : azimuth});
  };
  // Radius squared and azimuth: the square's unit is π of area.
  test.density = [](double, double) { return M_PI * static_cast<double>(disk_pdf()); };
  EXPECT_EQ(test::chi2_test(test), "");
}

TEST(Warp, TriangleFollowsItsDensity) {
  test::Chi2Case test;
  test.sample = [](test::Random& random) {
    const Vec2 b = square_to_triangle(random.next2());
    EXPECT_GE(1 - b.x - b.y, -1e-6F);
    return std::optional(Vec2{b.x, b.y / std::max(1e-6F, 1 - b.x)});
  };
  test.density = [](double s, double) { return static_cast<double>(triangle_pdf()) * (1 - s); };
  EXPECT_EQ(test::chi2_test(test), "");
}

TEST(Frame, IsOrthonormalAndRightHandedAroundAnyNormal) {
  test::Random random(3);
  for (int i = 0; i < 10'000; ++i) {
    const Vec3 n = i == 0 ? Vec3{0, 0, -1} : normalize(square_to_sphere(random.next2()));
    const Frame frame(n);
    EXPECT_NEAR(length(frame.s), 1, 1e-5F);
    EXPECT_NEAR(length(frame.t), 1, 1e-5F);
    EXPECT_NEAR(dot(frame.s, frame.t), 0, 1e-5F);
    EXPECT_NEAR(dot(frame.s, n), 0, 1e-5F);
    EXPECT_NEAR(dot(frame.t, n), 0, 1e-5F);
    EXPECT_NEAR(dot(cross(frame.s, frame.t), n), 1, 1e-5F);
    const Vec3 v = square_to_sphere(random.next2());
    EXPECT_NEAR(length(frame.to_world(frame.to_local(v)) - v), 0, 1e-5F);
  }
}

TEST(Chi2, TailsAreTheTabulatedOnes) {
  EXPECT_NEAR(test::chi2_tail(3.841, 1), 0.05, 1e-4);
  EXPECT_NEAR(test::chi2_tail(18.307, 10), 0.05, 1e-4);
  EXPECT_NEAR(test::chi2_tail(135.807, 100), 0.01, 1e-4);
  EXPECT_NEAR(test::chi2_tail(70.065, 100), 0.99, 1e-4);
}

TEST(Chi2, AWrongDensityFalls) {
  auto test = directions(square_to_cosine_hemisphere, hemisphere_pdf);
  EXPECT_NE(test::chi2_test(test), "");
  // Five in a hundred too many on one side.
  test = directions(square_to_cosine_hemisphere, [](const Vec3& v) {
    return cosine_hemisphere_pdf(v) * (v.x > 0 ? 1.05F : 0.95F);
  });
  EXPECT_NE(test::chi2_test(test), "");
  // Samples where the density is 0.
  test = directions(square_to_cosine_hemisphere,
                    [](const Vec3& v) { return v.z > 0.5F ? cosine_hemisphere_pdf(v) : 0; });
  EXPECT_NE(test::chi2_test(test), "");
}

}  // namespace
}  // namespace tessera::render
