#include "worker/render/filter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "common/base/error.hpp"
#include "tests/unit/render/chi2.hpp"

namespace tessera::render {
namespace {

/// Each filter's formula, apart from the code: of the distance from the centre, edge to edge
/// `width`; not normalised.
double formula(std::string_view name, double x, double width) {
  const double t = std::abs(x) / (width / 2);
  if (t > 1) return 0;
  if (name == "box") return 1;
  if (name == "tent") return 1 - t;
  if (name == "gaussian") return std::exp(-x * x / (2 * (width / 6) * (width / 6)));
  const double n = 0.5 + t / 2;
  return 0.35875 - 0.48829 * std::cos(2 * M_PI * n) + 0.14128 * std::cos(4 * M_PI * n) -
         0.01168 * std::cos(6 * M_PI * n);
}

double integral(std::string_view name, double width) {
  constexpr int steps = 100'000;
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    sum += formula(name, ((i + 0.5) / steps - 0.5) * width, width) * width / steps;
  }
  return sum;
}

class EveryFilter : public testing::TestWithParam<std::string_view> {
 protected:
  [[nodiscard]] static FilterKind kind() { return filter_kind(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(Names, EveryFilter, testing::ValuesIn(filter_names()),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(EveryFilter, DensityIsTheFormulaNormalised) {
  for (const double width : {0.0, 1.0, 4.5}) {
    const Filter filter(kind(), width);
    const double total = integral(GetParam(), filter.width());
    for (int i = -20; i <= 20; ++i) {
      const double x = filter.width() * i / 30;
      EXPECT_NEAR(filter.density(x), formula(GetParam(), x, filter.width()) / total, 3e-6) << x;
    }
  }
}

TEST_P(EveryFilter, SampledOffsetsFollowTheFormula) {
  const Filter filter(kind());
  const double total = integral(GetParam(), filter.width());
  test::Chi2Case test;
  test.samples = 1'000'000;
  test.sample = [&](test::Random& random) {
    const Vec2 offset = filter.sample(random.next2());
    const auto width = static_cast<float>(filter.width());
    return std::optional(Vec2{offset.x / width + 0.5F, offset.y / width + 0.5F});
  };
  test.density = [&](double s, double t) {
    const double width = filter.width();
    return formula(GetParam(), (s - 0.5) * width, width) *
           formula(GetParam(), (t - 0.5) * width, width) * width * width / (total * total);
  };
  EXPECT_EQ(test::chi2_test(test), "");
}

TEST_P(EveryFilter, OffsetsAreSymmetricAndStayWithinTheWidth) {
  const Filter filter(kind(), 2.5);
  double mean = 0;
  float most = 0;
  constexpr int steps = 1 << 14;
  for (int i = 1; i < steps; ++i) {
    const float u = static_cast<float>(i) / steps;
    const float x = filter.sample({u, 0.5F}).x;
    EXPECT_EQ(x, -filter.sample({1 - u, 0.5F}).x) << u;
    EXPECT_EQ(x, filter.sample({0.5F, u}).y);
    mean += static_cast<double>(x) / steps;
    most = std::max(most, std::abs(x));
  }
  EXPECT_NEAR(mean, 0, 1e-7);
  EXPECT_LE(most, 1.25F);
  EXPECT_GT(most, 0.8F);
  EXPECT_EQ(filter.sample({0.5F, 0.5F}), Vec2{});
  EXPECT_LE(std::abs(filter.sample({0, one_minus_epsilon}).x), 1.25F);
  EXPECT_LE(std::abs(filter.sample({0, one_minus_epsilon}).y), 1.25F);
  EXPECT_EQ(filter.density(1.26), 0);
}

TEST_P(EveryFilter, OffsetsRiseWithTheNumber) {
  const Filter filter(kind());
  float last = -1e30F;
  for (int i = 0; i < 20'000; ++i) {
    const float x = filter.sample({static_cast<float>(i) / 20'000, 0}).x;
    EXPECT_GE(x, last);
    last = x;
  }
}

TEST(Filter, DefaultWidthsAreTheOnesInTheHeader) {
  EXPECT_EQ(Filter(FilterKind::box).width(), 1);
  EXPECT_EQ(Filter(FilterKind::tent).width(), 2);
  EXPECT_EQ(Filter(FilterKind::gaussian).width(), 3);
  EXPECT_EQ(Filter(FilterKind::blackman_harris).width(), 3);
}

TEST(Filter, AnUnknownNameIsAnErrorThatNamesTheNearest) {
  EXPECT_THAT([] { filter_kind("gausian"); },
              testing::ThrowsMessage<Error>(testing::AllOf(
                  testing::HasSubstr("did you mean \"gaussian\""), testing::HasSubstr("box"))));
}

}  // namespace
}  // namespace tessera::render
