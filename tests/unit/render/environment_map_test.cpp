#include "worker/render/lights/environment_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/unit/render/chi2.hpp"
#include "worker/render/lights/by_area.hpp"
#include "worker/render/lights/light_table.hpp"

namespace tessera::render {
namespace {

image::Texels gray_floats(int width, int height, const std::vector<float>& values) {
  image::Texels out{width, height, 1, image::TexelFormat::f32, {}};
  out.bytes.resize(values.size() * sizeof(float));
  std::memcpy(out.bytes.data(), values.data(), out.bytes.size());
  return out;
}

EnvironmentMap map_of(int width, int height, const std::vector<float>& values, double turn = 0) {
  return EnvironmentMap(gray_floats(width, height, values), scene::ColorSpace::linear, turn);
}

/// Black but for noise in its upper part and a sun.
EnvironmentMap sky(int width, int height) {
  std::vector<float> values;
  std::uint32_t state = 7;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      state = state * 1664525U + 1013904223U;
      const float noise = static_cast<float>(state >> 24) / 255.0F;
      const bool sun = x == width / 3 && y == height / 4;
      values.push_back(sun ? 300.0F : y < height / 2 ? noise : 0.0F);
    }
  return map_of(width, height, values, 2 * M_PI / width);
}

TEST(EnvironmentMap, shows_the_middle_along_x_and_the_right_along_z_and_turns_about_y) {
  // Eight columns; the middle of column c is at u = (c + ½)/8.
  const std::vector<float> columns{0, 1, 2, 3, 4, 5, 6, 7};
  const auto seen = [&](double turn, double u) {
    const double azimuth = 2 * M_PI * (0.5 - u);  // of x towards −z
    return map_of(8, 1, columns, turn).radiance({std::cos(azimuth), 0, -std::sin(azimuth)}).r;
  };
  EXPECT_NEAR(map_of(8, 1, columns).radiance({1, 0, 0}).r, 3.5F, 1e-6);
  EXPECT_NEAR(map_of(8, 1, columns).radiance({0, 0, 1}).r, 5.5F, 1e-6);
  EXPECT_NEAR(map_of(8, 1, columns).radiance({0, 0, -1}).r, 1.5F, 1e-6);
  EXPECT_NEAR(map_of(8, 1, columns).radiance({-1, 0, 0}).r, 3.5F, 1e-6);  // the seam: 7 and 0
  EXPECT_NEAR(seen(0, 2.5 / 8), 2, 1e-5);
  // What lay along x lies along −z after a quarter turn, counter-clockwise from above.
  EXPECT_NEAR(map_of(8, 1, columns, M_PI / 2).radiance({0, 0, -1}).r, 3.5F, 1e-5);
  const EnvironmentMap rows = map_of(1, 4, {9, 5, 3, 1});
  EXPECT_NEAR(rows.radiance({0, 1, 0}).r, 9, 1e-6);
  EXPECT_NEAR(rows.radiance({0, 0, 1}).r, 4, 1e-6);
  EXPECT_NEAR(rows.radiance({0, -1, 0}).r, 1, 1e-6);
}

/// One of a map's two ways to draw directions.
struct Way {
  const char* name;
  EnvironmentMap::Drawn (EnvironmentMap::*sample)(Vec2) const;
  double (EnvironmentMap::*pdf)(const Vec3d&) const;
};
constexpr Way compensated{"compensated", &EnvironmentMap::sample, &EnvironmentMap::pdf};
constexpr Way plain{"plain", &EnvironmentMap::sample_all, &EnvironmentMap::pdf_all};

struct Case {
  Way way;
  int width, height;
};

class EnvironmentWays : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Sizes, EnvironmentWays,
                         testing::Values(Case{compensated, 16, 8}, Case{compensated, 5, 3},
                                         Case{compensated, 32, 16}, Case{plain, 16, 8},
                                         Case{plain, 5, 3}, Case{plain, 32, 16}),
                         [](const auto& test) {
                           return test.param.way.name + std::to_string(test.param.width);
                         });

TEST_P(EnvironmentWays, samples_follow_their_density) {
  const Case& param = GetParam();
  const Way& way = param.way;  // a structured binding is nothing that clang 14 captures
  const EnvironmentMap map = sky(param.width, param.height);
  test::Chi2Case test;
  test.bins_s = 2 * param.width;
  test.bins_t = 2 * param.height;
  test.samples = 300'000;
  test.quadrature = 8;
  test.sample = [&](test::Random& random) -> std::optional<Vec2> {
    const EnvironmentMap::Drawn drawn = (map.*way.sample)(random.next2());
    EXPECT_GT(drawn.pdf, 0);
    EXPECT_NEAR((map.*way.pdf)(drawn.direction), drawn.pdf, 1e-9 * drawn.pdf);
    EXPECT_GT(luminance(map.radiance(drawn.direction)), -1e-6);
    const double u = 0.5 - std::atan2(-drawn.direction.z, drawn.direction.x) / (2 * M_PI);
    return Vec2{static_cast<float>(u), static_cast<float>(std::acos(drawn.direction.y) / M_PI)};
  };
  test.density = [&](double s, double t) {
    const double azimuth = 2 * M_PI * (0.5 - s), sine = std::sin(M_PI * t);
    const Vec3d d{sine * std::cos(azimuth), std::cos(M_PI * t), -sine * std::sin(azimuth)};
    return (map.*way.pdf)(d)*2 * M_PI * M_PI * sine;
  };
  EXPECT_EQ(test::chi2_test(test), "");
}

TEST(EnvironmentMap, samples_at_the_edges_of_cells_have_the_density_of_their_directions) {
  // Of a picture of stripes every other edge stands at a number that is drawn, between a dark cell
  // and a bright one.
  constexpr int width = 64, height = 32;
  std::vector<float> stripes;
  for (int i = 0; i < width * height; ++i) stripes.push_back(i % 2 == 0 ? 1.0F : 3.0F);
  const EnvironmentMap striped = map_of(width, height, stripes), uneven = sky(width, height);
  test::Random random(8);
  for (const EnvironmentMap* map : {&striped, &uneven}) {
    for (int i = 0; i <= width; ++i) {
      const float x = std::min(static_cast<float>(i) / width, one_minus_epsilon);
      for (int j = 0; j < 50; ++j) {
        const Vec2 u{x, random.next()};
        const EnvironmentMap::Drawn all = map->sample_all(u), drawn = map->sample(u);
        ASSERT_NEAR(map->pdf_all(all.direction), all.pdf, 1e-9 * all.pdf) << x << ' ' << u.y;
        ASSERT_NEAR(map->pdf(drawn.direction), drawn.pdf, 1e-9 * drawn.pdf) << x << ' ' << u.y;
        const float seen = luminance(map->radiance(drawn.direction));
        ASSERT_NEAR(luminance(drawn.radiance), seen, 1e-4F * seen) << x << ' ' << u.y;
      }
    }
  }
}

TEST(EnvironmentMap, is_never_bright_where_it_is_never_sampled) {
  for (const auto& [width, height] : {std::pair{16, 8}, {2500, 1300}, {4100, 3}}) {
    const EnvironmentMap map = sky(width, height);
    test::Random random(3);
    for (int i = 0; i < 20000; ++i) {
      const float z = 2 * random.next() - 1;
      const double azimuth = 2 * M_PI * static_cast<double>(random.next());
      const double sine = std::sqrt(1 - double{z} * double{z});
      const Vec3d d{sine * std::cos(azimuth), z, sine * std::sin(azimuth)};
      const float light = luminance(map.radiance(d));
      if (light > 0) {
        ASSERT_GT(map.pdf_all(d), 0);
      }
      if (light > luminance(map.mean())) {
        ASSERT_GT(map.pdf(d), 0);
      }
    }
  }
}

TEST(EnvironmentMap, light_samples_sum_to_all_the_light_that_it_sends) {
  // Where a picture is no brighter than its mean it is left to BSDFs; by area nothing is.
  const EnvironmentMap map = sky(24, 12);
  const Light light = {.shape = EnvironmentLight{{}, 1, &map}, .radiance = gray(2)};
  // Over all directions, by the middles of small cells.
  double expected = 0;
  constexpr int steps = 1200;
  for (int y = 0; y < steps; ++y)
    for (int x = 0; x < steps; ++x) {
      const double theta = M_PI * (y + 0.5) / steps, phi = 2 * M_PI * (x + 0.5) / steps;
      const Vec3d d{std::sin(theta) * std::cos(phi), std::cos(theta),
                    std::sin(theta) * std::sin(phi)};
      expected += 2 * map.radiance(d).g * std::sin(theta) * (M_PI / steps) * (2 * M_PI / steps);
    }
  test::Random random(5);
  double sum = 0, squares = 0;
  constexpr int samples = 200'000;
  for (int i = 0; i < samples; ++i) {
    const LightSample drawn = sample_by_area(light, {}, random.next2());
    const double value = drawn.radiance.g / drawn.pdf;
    sum += value;
    squares += value * value;
    const LightSample brightest = sample(light, {}, random.next2());
    ASSERT_NEAR(pdf(light, {}, {.wi = brightest.wi}) / brightest.pdf, 1, 0.05F) << i;
  }
  const double mean = sum / samples;
  const double error = std::sqrt((squares / samples - mean * mean) / samples);
  EXPECT_LT(error, 0.003 * expected);
  EXPECT_NEAR(mean, expected, 5 * error + 1e-3 * expected);
  EXPECT_NEAR(power(light).g, expected * M_PI, 0.02 * expected * M_PI);
}

/// Mean and variance of what a white Lambertian surface that faces up gets, by a light sample and
/// a BSDF's each, weighed by the power heuristic.
struct Spread {
  double mean = 0, variance = 0;
};
Spread spread_of(const EnvironmentMap& map, const Way& way) {
  test::Random random(9);
  const auto cosine_pdf = [](const Vec3d& d) { return std::max(0.0, d.y) / M_PI; };
  const auto weight = [](double a, double b) { return a * a / (a * a + b * b); };
  const auto lit = [&](const Vec3d& d) { return double{map.radiance(d).g} * cosine_pdf(d); };
  double sum = 0, squares = 0;
  constexpr int samples = 400'000;
  for (int i = 0; i < samples; ++i) {
    double value = 0;
    const EnvironmentMap::Drawn light = (map.*way.sample)(random.next2());
    const double by_bsdf = cosine_pdf(light.direction);
    if (by_bsdf > 0) value += lit(light.direction) / light.pdf * weight(light.pdf, by_bsdf);
    const Vec2 u = random.next2();
    const double r = std::sqrt(double{u.x}), turn = 2 * M_PI * double{u.y};
    const Vec3d d{r * std::cos(turn), std::sqrt(1 - double{u.x}), r * std::sin(turn)};
    if (const double pdf = cosine_pdf(d); pdf > 0)
      value += lit(d) / pdf * weight(pdf, (map.*way.pdf)(d));
    sum += value;
    squares += value * value;
  }
  const double mean = sum / samples;
  return {mean, squares / samples - mean * mean};
}

TEST(EnvironmentMap, compensated_samples_have_the_same_mean_and_less_variance_under_a_sun) {
  // A bright sky and a sun that gives as much as a third of it.
  std::vector<float> values(64 * 32, 1.0F);
  values[64 * 8 + 20] = 400;
  const EnvironmentMap map = map_of(64, 32, values);
  const Spread all = spread_of(map, plain), some = spread_of(map, compensated);
  EXPECT_NEAR(some.mean, all.mean, 5 * std::sqrt((all.variance + some.variance) / 400'000));
  EXPECT_LT(some.variance, 0.8 * all.variance)
      << "by " << some.variance << " against " << all.variance;
}

TEST(EnvironmentMap, one_that_is_even_is_drawn_evenly) {
  const EnvironmentMap map = map_of(8, 4, std::vector<float>(32, 2.0F));
  EXPECT_NEAR(map.pdf({1, 0, 0}) / map.pdf_all({1, 0, 0}), 1, 1e-6);
  EXPECT_GT(map.sample({0.3F, 0.4F}).pdf, 0);
}

TEST(EnvironmentMap, a_black_one_gives_no_sample) {
  EXPECT_EQ(map_of(4, 2, std::vector<float>(8)).sample({0.3F, 0.4F}).pdf, 0);
}

}  // namespace
}  // namespace tessera::render
