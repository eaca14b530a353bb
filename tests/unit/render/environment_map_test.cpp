#include "worker/render/lights/environment_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/unit/render/chi2.hpp"
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

TEST(EnvironmentMap, samples_follow_their_density) {
  for (const auto& [width, height] : {std::pair{16, 8}, {5, 3}, {32, 16}}) {
    const EnvironmentMap map = sky(width, height);
    test::Chi2Case test;
    test.bins_s = 2 * width;
    test.bins_t = 2 * height;
    test.samples = 300'000;
    test.quadrature = 8;
    test.sample = [&](test::Random& random) -> std::optional<Vec2> {
      const EnvironmentMap::Drawn drawn = map.sample(random.next2());
      EXPECT_GT(drawn.pdf, 0);
      EXPECT_GT(luminance(map.radiance(drawn.direction)), -1e-6);
      const double u = 0.5 - std::atan2(-drawn.direction.z, drawn.direction.x) / (2 * M_PI);
      return Vec2{static_cast<float>(u), static_cast<float>(std::acos(drawn.direction.y) / M_PI)};
    };
    test.density = [&](double s, double t) {
      const double azimuth = 2 * M_PI * (0.5 - s), sine = std::sin(M_PI * t);
      return map.pdf({sine * std::cos(azimuth), std::cos(M_PI * t), -sine * std::sin(azimuth)}) *
             2 * M_PI * M_PI * sine;
    };
    EXPECT_EQ(test::chi2_test(test), "") << width;
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
      if (luminance(map.radiance(d)) > 0) {
        ASSERT_GT(map.pdf(d), 0);
      }
    }
  }
}

TEST(EnvironmentMap, light_samples_sum_to_all_the_light_that_it_sends) {
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
    const LightSample drawn = sample(light, {}, random.next2());
    const double value = drawn.radiance.g / drawn.pdf;
    sum += value;
    squares += value * value;
    ASSERT_NEAR(pdf(light, {}, {.wi = drawn.wi}) / drawn.pdf, 1, 0.05F) << i;
  }
  const double mean = sum / samples;
  const double error = std::sqrt((squares / samples - mean * mean) / samples);
  EXPECT_LT(error, 0.003 * expected);
  EXPECT_NEAR(mean, expected, 5 * error + 1e-3 * expected);
  EXPECT_NEAR(power(light).g, expected * M_PI, 0.02 * expected * M_PI);
}

TEST(EnvironmentMap, a_black_one_gives_no_sample) {
  EXPECT_EQ(map_of(4, 2, std::vector<float>(8)).sample({0.3F, 0.4F}).pdf, 0);
}

}  // namespace
}  // namespace tessera::render
