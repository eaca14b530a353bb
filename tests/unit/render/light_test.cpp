#include "worker/render/lights/light.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/render/chi2.hpp"
#include "worker/render/frame.hpp"

namespace tessera::render {
namespace {

/// A flat light, for tests: the points corner + s·u + t·v, of a triangle those with s + t ≤ 1.
struct Flat {
  Vec3d corner, u, v;
  bool triangle = false;

  [[nodiscard]] Light light() const {
    const Vec3 c = to_float(corner);
    if (triangle) {
      return {.shape = TriangleLight{c, c + to_float(u), c + to_float(v)}, .radiance = gray(2)};
    }
    return {.shape = QuadLight{c, to_float(u), to_float(v)}, .radiance = gray(2)};
  }
  [[nodiscard]] Vec3d normal() const { return cross(u, v); }
  /// A triangle's square: its parallelogram coordinates (s, t) are (s, t'·(1 − s)).
  [[nodiscard]] Vec3d at(double s, double t) const {
    return corner + u * s + v * (triangle ? t * (1 - s) : t);
  }
  [[nodiscard]] Vec2 square_of(const Vec3d& point) const {
    const Vec3d d = point - corner, n = normal();
    const double s = dot(cross(d, v), n) / length_squared(n),
                 t = dot(cross(u, d), n) / length_squared(n);
    const double beyond = triangle ? s + t - 1 : std::max(s, t) - 1;
    EXPECT_LT(std::max({-s, -t, beyond}), 2e-4) << "outside the light: " << s << ' ' << t;
    return {static_cast<float>(s), static_cast<float>(triangle ? t / std::max(1 - s, 1e-9) : t)};
  }
};

/// Where a sampled direction meets the light, and how densely pdf() says that it does.
test::Chi2Case on_flat(const Flat& flat, const Vec3& p) {
  test::Chi2Case test;
  const Light light = flat.light();
  const LightContext context{.p = p};
  const Vec3d origin = to_double(p);
  test.sample = [=](test::Random& random) -> std::optional<Vec2> {
    const LightSample drawn = sample(light, context, random.next2());
    if (!drawn) return std::nullopt;
    const LightHit hit{.wi = drawn.wi, .distance = drawn.distance};
    EXPECT_NEAR(pdf(light, context, hit) / drawn.pdf, 1, 1e-4F);
    EXPECT_NEAR(length(drawn.wi), 1, 1e-5F);
    EXPECT_EQ(drawn.radiance, gray(2));
    EXPECT_EQ(emitted(light, context, drawn.wi), gray(2));
    const Vec3d wi = to_double(drawn.wi), n = flat.normal();
    const double distance = dot(flat.corner - origin, n) / dot(wi, n);
    EXPECT_NEAR(static_cast<double>(drawn.distance) / distance, 1, 2e-3);
    return flat.square_of(origin + wi * distance);
  };
  test.density = [=](double s, double t) {
    const Vec3d d = flat.at(s, t) - origin;
    const double distance = length(d);
    const Vec3d wi = d / distance;
    // From solid angle to area to the square.
    const double per_angle = static_cast<double>(
        pdf(light, context, {.wi = to_float(wi), .distance = static_cast<float>(distance)}));
    const double area = std::abs(dot(flat.normal(), wi)) * (flat.triangle ? 1 - s : 1);
    return per_angle * area / (distance * distance);
  };
  return test;
}

const Flat rectangle{{-1, 0, 3}, {2, 0, 0}, {0, -1.5, 0}};
const Flat slanted{{-1, 0.3, 3}, {1.6, 0.4, 0.3}, {-0.7, -1.5, 0.5}};
const Flat triangle{{-1, 0, 3}, {2, 0.3, 0.2}, {0.4, -1.5, -0.3}, true};
// Far and small: sampled by area.
const Flat small_rectangle{{5, 5, 40}, {0.02, 0, 0}, {0, -0.03, 0}};
const Flat small_triangle{{5, 5, 40}, {0.2, 0, 0}, {0, -0.3, 0}, true};
const Flat small_slanted{{5, 5, 40}, {0.2, 0, 0}, {0.1, -0.2, 0}};
// Long against its distance: the light fills nearly half of all directions.
const Flat vast_triangle{{-40, 50, 0.5}, {90, 0, 0}, {0, -90, 0}, true};

struct Place {
  const char* name;
  const Flat* flat;
  Vec3 p;
};
const Place places[] = {
    {"rectangle_from_afar", &rectangle, {0.3F, 0.2F, 0}},
    {"rectangle_from_one_side", &rectangle, {6, 2, 1}},
    {"rectangle_from_near", &rectangle, {0.1F, -0.6F, 2.7F}},
    {"rectangle_from_near_its_edge", &rectangle, {-1.3F, -0.1F, 2.8F}},
    {"rectangle_grazing", &rectangle, {4, -0.5F, 2.97F}},
    {"rectangle_under_its_corner", &rectangle, {-1, 0, 2}},
    {"slanted_from_afar", &slanted, {0.3F, 0.2F, 0}},
    {"slanted_from_near", &slanted, {0.1F, -0.4F, 2.8F}},
    {"slanted_grazing", &slanted, {5, 1, 3.5F}},
    {"triangle_from_afar", &triangle, {0.3F, 0.2F, 0}},
    {"triangle_from_near", &triangle, {-0.2F, -0.3F, 2.8F}},
    {"triangle_grazing", &triangle, {5, 0, 3.2F}},
    {"triangle_from_very_far", &triangle, {100, 30, -40}},
    {"triangle_under_its_corner", &triangle, {-1, 0, 2.5F}},
    {"triangle_vast", &vast_triangle, {0, 0, 0}},
    {"small_rectangle", &small_rectangle, {0, 0, 0}},
    {"small_triangle", &small_triangle, {0, 0, 0}},
    {"small_slanted", &small_slanted, {0, 0, 0}},
};

class FlatLight : public testing::TestWithParam<Place> {};
INSTANTIATE_TEST_SUITE_P(Places, FlatLight, testing::ValuesIn(places),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_P(FlatLight, SamplesFollowTheirDensity) {
  test::Chi2Case test = on_flat(*GetParam().flat, GetParam().p);
  // The density has a narrow peak where the light is near.
  if (GetParam().flat == &vast_triangle) test.quadrature = 16;
  EXPECT_EQ(test::chi2_test(test), "");
}

// ---- spheres: by the height in the cone, and the azimuth ----

test::Chi2Case on_sphere(const SphereLight& sphere, const Vec3& p, bool two_sided) {
  test::Chi2Case test;
  const Light light = {.shape = sphere, .radiance = gray(3), .two_sided = two_sided};
  const LightContext context{.p = p};
  const Vec3d axis = to_double(sphere.center) - to_double(p);
  const double d = length(axis), r = static_cast<double>(sphere.radius);
  const bool inside = d < r;
  const double cap = inside ? 2 : 1 - std::sqrt(1 - r * r / (d * d));
  const FrameD frame(d > 0 ? axis / d : Vec3d{0, 0, 1});
  test.sample = [=](test::Random& random) -> std::optional<Vec2> {
    const LightSample drawn = sample(light, context, random.next2());
    if (!drawn) return std::nullopt;
    EXPECT_NEAR(pdf(light, context, {.wi = drawn.wi, .distance = drawn.distance}) / drawn.pdf, 1,
                1e-5F);
    EXPECT_EQ(emitted(light, context, drawn.wi), gray(3));
    // The point that it means is on the sphere.
    const Vec3d point = to_double(p) + to_double(drawn.wi) * static_cast<double>(drawn.distance);
    EXPECT_NEAR(length(point - to_double(sphere.center)) / r, 1, 1e-3 + 1e-6 * d / r);
    const Vec3d local = frame.to_local(to_double(drawn.wi));
    // 1 − cos θ by the sine, which the float direction tells better.
    const double sin2 = local.x * local.x + local.y * local.y;
    const double height = local.z > 0 ? sin2 / (1 + local.z) : 1 - local.z;
    EXPECT_LE(height, cap * 1.001);
    const double azimuth = std::atan2(local.y, local.x) / (2 * M_PI);
    return Vec2{static_cast<float>(height / cap),
                static_cast<float>(azimuth < 0 ? azimuth + 1 : azimuth)};
  };
  test.density = [=](double s, double t) {
    const double z = 1 - cap * s, sine = std::sqrt(std::max(0.0, 1 - z * z));
    const Vec3d wi =
        frame.to_world({sine * std::cos(2 * M_PI * t), sine * std::sin(2 * M_PI * t), z});
    return static_cast<double>(pdf(light, context, {.wi = to_float(wi)})) * 2 * M_PI * cap;
  };
  return test;
}

TEST(SphereLight, SamplesFollowTheirDensityFromOutside) {
  EXPECT_EQ(test::chi2_test(on_sphere({{1, 2, 3}, 0.5F}, {0, 0, 0}, false)), "");
  EXPECT_EQ(test::chi2_test(on_sphere({{1, 2, 3}, 3.7F}, {0, 0, 0}, false)), "")
      << "almost upon it";
  EXPECT_EQ(test::chi2_test(on_sphere({{100, 0, 300}, 0.2F}, {0, 0, 0}, false)), "") << "far";
}

TEST(SphereLight, SamplesFollowTheirDensityFromInside) {
  EXPECT_EQ(test::chi2_test(on_sphere({{1, 2, 3}, 5}, {0, 0, 0}, true)), "");
  EXPECT_EQ(test::chi2_test(on_sphere({{0, 0, 0}, 2}, {0, 0, 0}, true)), "");
}

TEST(SphereLight, OneThatEmitsOutwardsGivesNothingInside) {
  const Light light = {.shape = SphereLight{{0, 0, 0}, 2}, .radiance = gray(1)};
  EXPECT_FALSE(static_cast<bool>(sample(light, {.p = {0.5F, 0, 0}}, {0.3F, 0.4F})));
  EXPECT_EQ(emitted(light, {.p = {0.5F, 0, 0}}, {1, 0, 0}), Color{});
  EXPECT_EQ(pdf(light, {.p = {0.5F, 0, 0}}, {.wi = {1, 0, 0}}), 0);
}

TEST(SphereLight, TheSunIsAsLargeAsItIs) {
  // Facts, case 12: half-angle .2665°.
  const double radius = 1.495978707e11 * std::sin(0.2665 * M_PI / 180);
  const Light light = {.shape = SphereLight{{0, 1.495978707e11F, 0}, static_cast<float>(radius)},
                       .radiance = gray(1)};
  const LightSample drawn = sample(light, {}, {0.7F, 0.2F});
  EXPECT_NEAR(1 / drawn.pdf, 6.796702e-5, 2e-11);
}

// ---- sun ----

TEST(SunLight, SamplesFollowTheirDensity) {
  for (const double degrees : {0.2665, 20.0, 90.0}) {
    const double half = std::sin(degrees * M_PI / 360);
    const SunLight sun{normalize(Vec3{1, -2, 0.5F}), 2 * half * half};
    const Light light = {.shape = sun, .radiance = gray(3)};
    const FrameD frame(-normalize(to_double(sun.direction)));
    test::Chi2Case test;
    test.sample = [=](test::Random& random) -> std::optional<Vec2> {
      const LightSample drawn = sample(light, {}, random.next2());
      EXPECT_TRUE(std::isinf(drawn.distance) && !drawn.delta);
      const Vec3d local = frame.to_local(to_double(drawn.wi));
      const double sin2 = local.x * local.x + local.y * local.y;
      const double height = (local.z > 0 ? sin2 / (1 + local.z) : 1 - local.z) / sun.cap;
      // At the rim the float direction decides on which side it is.
      if (height < 0.9999) {
        EXPECT_EQ(pdf(light, {}, {.wi = drawn.wi}), drawn.pdf);
        EXPECT_EQ(emitted(light, {}, drawn.wi), gray(3));
      }
      const double azimuth = std::atan2(local.y, local.x) / (2 * M_PI);
      return Vec2{static_cast<float>(height),
                  static_cast<float>(azimuth < 0 ? azimuth + 1 : azimuth)};
    };
    test.density = [=](double s, double t) {
      const double z = 1 - sun.cap * s, sine = std::sqrt(std::max(0.0, 1 - z * z));
      const Vec3d wi =
          frame.to_world({sine * std::cos(2 * M_PI * t), sine * std::sin(2 * M_PI * t), z});
      return static_cast<double>(pdf(light, {}, {.wi = to_float(wi)})) * 2 * M_PI * sun.cap;
    };
    EXPECT_EQ(test::chi2_test(test), "") << degrees;
  }
  const Light light = {.shape = SunLight{{0, -1, 0}, 0.1}, .radiance = gray(3)};
  EXPECT_EQ(pdf(light, {}, {.wi = {1, 0, 0}}), 0);
  EXPECT_EQ(emitted(light, {}, {0, -1, 0}), Color{}) << "behind it";
}

TEST(SunLight, ASurfaceThatFacesItGetsWhatFactsSay) {
  // Facts, case 12: half-angle .2665°, E/L = 6.796666e-5.
  const double half = std::sin(0.13325 * M_PI / 180);
  const Light light = {.shape = SunLight{{0, -1, 0}, 2 * half * half}, .radiance = gray(1)};
  EXPECT_NEAR(irradiance(light).r, 6.796666e-5, 1e-10);
  EXPECT_NEAR(1 / sample(light, {}, {0.3F, 0.4F}).pdf, 6.796702e-5, 1e-10);
}

// ---- environment ----

TEST(EnvironmentLight, SamplesFollowTheirDensity) {
  for (const Vec3& n : {Vec3{}, normalize(Vec3{1, 2, -2})}) {
    const Light light = {.shape = EnvironmentLight{}, .radiance = gray(1)};
    const LightContext context{.p = {1, 2, 3}, .n = n};
    const Frame frame = n == Vec3{} ? Frame() : Frame(n);
    test::Chi2Case test;
    test.sample = [=](test::Random& random) -> std::optional<Vec2> {
      const LightSample drawn = sample(light, context, random.next2());
      EXPECT_EQ(drawn.distance, std::numeric_limits<float>::infinity());
      EXPECT_NEAR(pdf(light, context, {.wi = drawn.wi}) / drawn.pdf, 1, 2e-2F);
      const Vec3 local = frame.to_local(drawn.wi);
      const float azimuth = std::atan2(local.y, local.x) / (2 * pi);
      return Vec2{0.5F * (1 + local.z), azimuth < 0 ? azimuth + 1 : azimuth};
    };
    test.density = [=](double s, double t) {
      const double z = 2 * s - 1, r = std::sqrt(std::max(0.0, 1 - z * z));
      const Vec3d local{r * std::cos(2 * M_PI * t), r * std::sin(2 * M_PI * t), z};
      return 4 * M_PI *
             static_cast<double>(pdf(light, context, {.wi = frame.to_world(to_float(local))}));
    };
    EXPECT_EQ(test::chi2_test(test), "");
  }
}

// ---- sides, bounds, power ----

TEST(Light, AFlatLightEmitsOnItsFrontUnlessItHasTwo) {
  for (const Flat* flat : {&rectangle, &slanted, &triangle}) {
    Light light = flat->light();
    const Vec3d center = flat->at(0.3, 0.3);
    const Vec3d n = normalize(flat->normal());
    const LightContext front{.p = to_float(center + n)}, back{.p = to_float(center - n)};
    EXPECT_TRUE(static_cast<bool>(sample(light, front, {0.5F, 0.5F})));
    EXPECT_FALSE(static_cast<bool>(sample(light, back, {0.5F, 0.5F})));
    EXPECT_EQ(pdf(light, back, {.wi = to_float(n), .distance = 1}), 0);
    EXPECT_EQ(emitted(light, front, to_float(-n)), gray(2));
    EXPECT_EQ(emitted(light, back, to_float(n)), Color{});
    light.two_sided = true;
    EXPECT_TRUE(static_cast<bool>(sample(light, back, {0.5F, 0.5F})));
    EXPECT_GT(pdf(light, back, {.wi = to_float(n), .distance = 1}), 0);
    EXPECT_EQ(emitted(light, back, to_float(n)), gray(2));
  }
}

TEST(Light, NothingIsSampledFromWithinItsPlaneOrOfNoArea) {
  EXPECT_FALSE(static_cast<bool>(sample(rectangle.light(), {.p = {5, 0, 3}}, {0.5F, 0.5F})));
  const Light line = {
      .shape = QuadLight{{0, 0, 1}, {1, 0, 0}, {2, 0, 0}}, .radiance = gray(1), .two_sided = true};
  EXPECT_FALSE(static_cast<bool>(sample(line, {}, {0.5F, 0.5F})));
  const Light point = {.shape = TriangleLight{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}},
                       .radiance = gray(1)};
  EXPECT_FALSE(static_cast<bool>(sample(point, {}, {0.5F, 0.5F})));
}

TEST(Light, EverySampleIsFiniteWhereverItIsSeenFrom) {
  test::Random random(6);
  for (int i = 0; i < 100'000; ++i) {
    const float scale = std::pow(10.0F, 8 * random.next() - 6);
    const auto vector = [&] {
      const float x = random.next(), y = random.next(), z = random.next();
      return Vec3{x - 0.5F, y - 0.5F, z - 0.5F};
    };
    const Vec3 a = vector(), u = vector() * scale, v = vector() * scale;
    const LightContext context{.p = random.next() < 0.1F ? a + u * 0.3F + v * 0.3F : vector()};
    const Light lights[] = {
        {.shape = QuadLight{a, u, v}, .radiance = gray(1), .two_sided = true},
        {.shape = QuadLight{a, u, cross(u, v) * (1 / length(u))},
         .radiance = gray(1),
         .two_sided = true},
        {.shape = TriangleLight{a, a + u, a + v}, .radiance = gray(1), .two_sided = true},
        {.shape = SphereLight{a, scale}, .radiance = gray(1), .two_sided = true}};
    for (const Light& light : lights) {
      const LightSample drawn = sample(light, context, random.next2());
      if (!drawn) continue;
      EXPECT_TRUE(is_finite(drawn.wi) && std::isfinite(drawn.pdf) && std::isfinite(drawn.distance));
      EXPECT_NEAR(length(drawn.wi), 1, 1e-5F);
      EXPECT_GE(drawn.distance, 0);
    }
  }
}

TEST(Light, BoundsConesAndPowers) {
  const Bounds3 quad_box = bounds(rectangle.light());
  EXPECT_EQ(quad_box.low, (Vec3{-1, -1.5F, 3}));
  EXPECT_EQ(quad_box.high, (Vec3{1, 0, 3}));
  EXPECT_EQ(cone(rectangle.light()).axis, (Vec3{0, 0, -1}));
  EXPECT_EQ(cone(rectangle.light()).cos_theta_o, 1);
  EXPECT_FLOAT_EQ(power(rectangle.light()).g, 2 * 3 * pi);  // radiance 2, area 3
  Light both = rectangle.light();
  both.two_sided = true;
  EXPECT_FLOAT_EQ(power(both).g, 2 * power(rectangle.light()).g);
  EXPECT_EQ(cone(both).cos_theta_o, -1);

  const Light sphere = {.shape = SphereLight{{1, 2, 3}, 2}, .radiance = {1, 2, 3}};
  EXPECT_EQ(bounds(sphere).low, (Vec3{-1, 0, 1}));
  EXPECT_EQ(bounds(sphere).high, (Vec3{3, 4, 5}));
  EXPECT_FLOAT_EQ(power(sphere).b, 3 * pi * 4 * pi * 4);
  const Light flat = {.shape = TriangleLight{{0, 0, 0}, {2, 0, 0}, {0, 3, 0}}, .radiance = gray(1)};
  EXPECT_FLOAT_EQ(power(flat).r, pi * 3);
  EXPECT_EQ(cone(flat).axis, (Vec3{0, 0, 1}));
  const Light sky = {.shape = EnvironmentLight{{}, 10}, .radiance = gray(1)};
  EXPECT_TRUE(bounds(sky).empty());
  EXPECT_FLOAT_EQ(power(sky).r, 4 * pi * pi * 100);
}

}  // namespace
}  // namespace tessera::render
