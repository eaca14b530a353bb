#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/render/chi2.hpp"
#include "worker/render/fastmath.hpp"
#include "worker/render/lights/by_area.hpp"
#include "worker/render/lights/light.hpp"
#include "worker/render/lights/spherical_disk.hpp"

namespace tessera::render {
namespace {

/// The plainest quadrature, ring by ring.
double summed_solid_angle(const Vec3d& center, double radius) {
  constexpr int rings = 600, parts = 600;
  double sum = 0;
  for (int i = 0; i < rings; ++i) {
    const double r = radius * (i + 0.5) / rings;
    for (int j = 0; j < parts; ++j) {
      const double turn = 2 * M_PI * (j + 0.5) / parts;
      const Vec3d p = center + Vec3d{r * std::cos(turn), r * std::sin(turn), 0};
      const double square = length_squared(p);
      sum += r * std::abs(center.z) / (square * std::sqrt(square));
    }
  }
  return sum * (radius / rings) * (2 * M_PI / parts);
}

TEST(SphericalDisk, SolidAngleIsThatOfAllItsParts) {
  const Vec3d up{0, 0, 1};
  for (const double h : {0.3, 1.0, 4.0})
    for (const double aside : {0.0, 0.4, 0.99, 1.0, 1.3, 5.0}) {
      const Vec3d center{0.6 * aside, -0.8 * aside, h};
      EXPECT_NEAR(SphericalDisk(center, up, 1).solid_angle() / summed_solid_angle(center, 1), 1,
                  2e-5)
          << h << ' ' << aside;
      EXPECT_EQ(SphericalDisk(-center, up, 1).solid_angle(),
                SphericalDisk(center, up, 1).solid_angle());
    }
  for (const double h : {1e-6, 0.1, 1.0, 1e3}) {
    const double axial = 2 * M_PI * (1 / (h * h + 1)) / (1 + h / std::sqrt(h * h + 1));
    EXPECT_NEAR(SphericalDisk({0, 0, h}, up, 1).solid_angle() / axial, 1, 1e-9) << h;
  }
  EXPECT_EQ(SphericalDisk({2, 0, 0}, up, 1).solid_angle(), 0) << "within its plane";
}

/// A place in the disk as one of the unit square: its radius squared, and its azimuth.
struct Seen {
  Light light;
  LightContext context;
  Vec3d center, u, v;

  Seen(const DiskLight& disk, const Vec3& p)
      : light{.shape = disk, .radiance = gray(2)},
        context{.p = p},
        center(to_double(disk.center)),
        u(to_double(disk.axis_u)),
        v(to_double(disk.axis_v)) {}

  [[nodiscard]] Vec3d normal() const { return cross(u, v); }
  [[nodiscard]] Vec2 square_of(const Vec3d& point) const {
    const Vec3d d = point - center, n = normal();
    const double x = dot(cross(d, v), n) / length_squared(n),
                 y = dot(cross(u, d), n) / length_squared(n);
    EXPECT_LT(x * x + y * y, 1 + 1e-3) << "outside the light";
    const double turn = std::atan2(y, x) / (2 * M_PI);
    return {static_cast<float>(x * x + y * y), static_cast<float>(turn < 0 ? turn + 1 : turn)};
  }
  [[nodiscard]] Vec3d at(double s, double t) const {
    const double r = std::sqrt(s);
    return center + u * (r * std::cos(2 * M_PI * t)) + v * (r * std::sin(2 * M_PI * t));
  }
};

using Draw = LightSample (*)(const Light&, const LightContext&, Vec2);

test::Chi2Case on_disk(const Seen& seen, Draw draw) {
  test::Chi2Case test;
  const Vec3d origin = to_double(seen.context.p);
  const bool by_area = draw == sample_by_area;
  const auto density_along = [=](const Vec3d& wi, double distance) {
    const double area = M_PI * length(seen.normal());
    if (by_area) return distance * distance / (std::abs(dot(wi, normalize(seen.normal()))) * area);
    return static_cast<double>(pdf(seen.light, seen.context,
                                   {.wi = to_float(wi), .distance = static_cast<float>(distance)}));
  };
  test.sample = [=](test::Random& random) -> std::optional<Vec2> {
    const LightSample drawn = draw(seen.light, seen.context, random.next2());
    if (!drawn) return std::nullopt;
    const Vec3d wi = to_double(drawn.wi), n = seen.normal();
    const double distance = dot(seen.center - origin, n) / dot(wi, n);
    EXPECT_NEAR(static_cast<double>(drawn.distance) / distance, 1, 2e-3);
    EXPECT_NEAR(density_along(wi, distance) / static_cast<double>(drawn.pdf), 1, 2e-3);
    EXPECT_EQ(emitted(seen.light, seen.context, drawn.wi), gray(2));
    return seen.square_of(origin + wi * distance);
  };
  test.density = [=](double s, double t) {
    const Vec3d d = seen.at(s, t) - origin;
    const double distance = length(d);
    const Vec3d wi = d / distance;
    // x = √s·cos, y = √s·sin: ds dt covers π times as much of the unit disk.
    return density_along(wi, distance) * std::abs(dot(seen.normal(), wi)) * M_PI /
           (distance * distance);
  };
  return test;
}

const DiskLight circle{{0.2F, -0.1F, 3}, {1, 0, 0}, {0, -1, 0}};
const DiskLight tilted{{0.2F, -0.1F, 3}, {0.6F, 0, 0.8F}, {0, -1, 0}};
/// Its normal has three components alike.
const DiskLight diagonal{{1, 1, 1}, {0.5F, -0.5F, 0}, {0.2886751F, 0.2886751F, -0.5773503F}};
const DiskLight ellipse{{0.2F, -0.1F, 3}, {1.5F, 0.2F, 0}, {0.3F, -0.7F, 0.1F}};
const DiskLight small{{5, 5, 40}, {0.02F, 0, 0}, {0, -0.02F, 0}};

struct Place {
  const char* name;
  const DiskLight* disk;
  Vec3 p;
};
const Place places[] = {
    {"from_afar", &circle, {0.3F, 0.2F, 0}},
    {"on_its_axis", &circle, {0.2F, -0.1F, 1}},
    {"from_near", &circle, {0.5F, -0.4F, 2.8F}},
    {"from_one_side", &circle, {6, 2, 1}},
    {"under_its_rim", &circle, {1.2F, -0.1F, 2}},
    {"grazing", &circle, {4, -0.5F, 2.9F}},
    {"beside_its_rim", &circle, {1.3F, 0, 2.9F}},
    {"tilted", &tilted, {0.3F, 0.2F, 0}},
    {"diagonal", &diagonal, {2, 2, 2}},
    {"ellipse", &ellipse, {0.3F, 0.2F, 0}},
    {"small", &small, {0, 0, 0}},
};

class DiskPlace : public testing::TestWithParam<Place> {};
INSTANTIATE_TEST_SUITE_P(Places, DiskPlace, testing::ValuesIn(places),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_P(DiskPlace, SamplesFollowTheirDensity) {
  const Seen seen(*GetParam().disk, GetParam().p);
  EXPECT_EQ(test::chi2_test(on_disk(seen, sample)), "");
}

TEST(DiskLight, SamplesByAreaFollowTheirDensity) {
  for (const DiskLight* disk : {&circle, &ellipse})
    EXPECT_EQ(test::chi2_test(on_disk(Seen(*disk, {0.3F, 0.2F, 0}), sample_by_area)), "");
}

TEST(DiskLight, ShinesOnItsFrontUnlessItHasTwoSides) {
  Light light = {.shape = circle, .radiance = gray(2)};
  const LightContext front{.p = {0, 0, 0}}, back{.p = {0, 0, 6}};
  EXPECT_TRUE(static_cast<bool>(sample(light, front, {0.5F, 0.4F})));
  EXPECT_FALSE(static_cast<bool>(sample(light, back, {0.5F, 0.4F})));
  EXPECT_EQ(pdf(light, back, {.wi = {0, 0, -1}, .distance = 3}), 0);
  EXPECT_EQ(emitted(light, front, {0, 0, 1}), gray(2));
  EXPECT_EQ(emitted(light, back, {0, 0, -1}), Color{});
  light.two_sided = true;
  EXPECT_TRUE(static_cast<bool>(sample(light, back, {0.5F, 0.4F})));
  EXPECT_EQ(emitted(light, back, {0, 0, -1}), gray(2));
  EXPECT_FALSE(static_cast<bool>(sample(light, {.p = {5, 0, 3}}, {0.5F, 0.5F})))
      << "from within its plane";
}

TEST(DiskLight, BoundsConeAndPower) {
  const Light light = {.shape = ellipse, .radiance = gray(3)};
  const Bounds3 box = bounds(light);
  const Seen seen(ellipse, {});
  Bounds3 found;
  for (int i = 0; i < 1000; ++i) found.grow(to_float(seen.at(1, i / 1000.0)));
  for (const auto& [a, b] : {std::pair(box.low, found.low), std::pair(box.high, found.high)})
    EXPECT_LT(length(a - b), 1e-4F);
  const auto area = static_cast<float>(M_PI * length(seen.normal()));
  EXPECT_NEAR(power(light).r / (3 * pi * area), 1, 1e-5F);
  EXPECT_NEAR(intensity(light).r / (3 * area), 1, 1e-5F);
  EXPECT_EQ(cone(light).cos_theta_o, 1);
  EXPECT_GT(dot(cone(light).axis, to_float(normalize(seen.normal()))), 0.9999F);
}

}  // namespace
}  // namespace tessera::render
