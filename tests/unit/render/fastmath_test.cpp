#include "worker/render/fastmath.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "worker/render/hash.hpp"

namespace tessera::render {
namespace {

/// In units in the last place of the float nearest to the truth.
double ulps(float value, double truth) {
  const auto nearest = static_cast<float>(truth);
  const double ulp = static_cast<double>(
      std::nextafter(std::abs(nearest), std::numeric_limits<float>::infinity()) -
      std::abs(nearest));
  return std::abs(static_cast<double>(value) - truth) / ulp;
}

/// Evenly and finely, ends included.
template <class F>
void sweep(double low, double high, int steps, F&& f) {
  for (int i = 0; i <= steps; ++i) f(low + (high - low) * i / steps);
}

/// The worst error of a float function over a range.
template <class Fast, class Exact>
double worst_ulps(double low, double high, Fast&& fast_f, Exact&& exact_f) {
  double worst = 0;
  sweep(low, high, 200'000, [&](double x) {
    const auto xf = static_cast<float>(x);
    const double truth = exact_f(static_cast<double>(xf));
    if (std::abs(truth) < 1e-30) return;
    worst = std::max(worst, ulps(fast_f(xf), truth));
  });
  return worst;
}

/// The worst error of a double function, relative to `scale(truth)`, in units of 2^-52.
template <class Fast, class Exact>
double worst_double(double low, double high, bool absolute, Fast&& fast_f, Exact&& exact_f) {
  double worst = 0;
  sweep(low, high, 200'000, [&](double x) {
    const double truth = exact_f(x);
    if (truth == 0) return;
    worst = std::max(worst, std::abs(fast_f(x) - truth) / (absolute ? 1 : std::abs(truth)));
  });
  return worst * 0x1p52;
}

constexpr double float_bound = 0.52;
constexpr double double_bound = 4;

#define FLOAT_FUNCTION(f) [](float x) { return fast::f(x); }, [](double x) { return std::f(x); }
#define DOUBLE_FUNCTION(f) [](double x) { return fast::f(x); }, [](double x) { return std::f(x); }

TEST(FastMath, FloatSineAndCosineKeepTheirBound) {
  EXPECT_LE(worst_ulps(-10, 10, FLOAT_FUNCTION(sin)), float_bound);
  EXPECT_LE(worst_ulps(-10, 10, FLOAT_FUNCTION(cos)), float_bound);
  EXPECT_LE(worst_ulps(-1e5, 1e5, FLOAT_FUNCTION(sin)), float_bound);
  EXPECT_LE(worst_ulps(-1e5, 1e5, FLOAT_FUNCTION(cos)), float_bound);
}

TEST(FastMath, FloatInverseFunctionsKeepTheirBound) {
  EXPECT_LE(worst_ulps(-1, 1, FLOAT_FUNCTION(acos)), float_bound);
  EXPECT_LE(worst_ulps(-1, 1, FLOAT_FUNCTION(asin)), float_bound);
  EXPECT_LE(worst_ulps(-5, 5, FLOAT_FUNCTION(atan)), float_bound);
  EXPECT_LE(worst_ulps(-1e6, 1e6, FLOAT_FUNCTION(atan)), float_bound);
}

TEST(FastMath, FloatExponentialAndLogarithmKeepTheirBound) {
  EXPECT_LE(worst_ulps(-87.3, 88.7, FLOAT_FUNCTION(exp)), float_bound);
  EXPECT_LE(worst_ulps(-1, 1, FLOAT_FUNCTION(exp)), float_bound);
  EXPECT_LE(worst_ulps(1e-6, 2, FLOAT_FUNCTION(log)), float_bound);
  EXPECT_LE(worst_ulps(0.9, 1.1, FLOAT_FUNCTION(log)), float_bound);
  EXPECT_LE(worst_ulps(1, 1e30, FLOAT_FUNCTION(log)), float_bound);
  for (const float exponent : {-3.5F, -1.0F, 0.2F, 0.5F, 2.4F, 10.0F}) {
    EXPECT_LE(worst_ulps(
                  1e-3, 100, [&](float x) { return fast::pow(x, exponent); },
                  [&](double x) { return std::pow(x, static_cast<double>(exponent)); }),
              float_bound)
        << exponent;
  }
}

TEST(FastMath, DoubleFunctionsKeepTheirBound) {
  EXPECT_LE(worst_double(-1e5, 1e5, true, DOUBLE_FUNCTION(sin)), double_bound);
  EXPECT_LE(worst_double(-7, 7, true, DOUBLE_FUNCTION(cos)), double_bound);
  EXPECT_LE(worst_double(-1, 1, false, DOUBLE_FUNCTION(acos)), double_bound);
  EXPECT_LE(worst_double(-1, 1, false, DOUBLE_FUNCTION(asin)), double_bound);
  EXPECT_LE(worst_double(-20, 20, false, DOUBLE_FUNCTION(atan)), double_bound);
  EXPECT_LE(worst_double(-700, 700, false, DOUBLE_FUNCTION(exp)), double_bound);
  EXPECT_LE(worst_double(1e-5, 3, false, DOUBLE_FUNCTION(log)), double_bound);
  EXPECT_LE(worst_double(1, 1e300, false, DOUBLE_FUNCTION(log)), double_bound);
}

TEST(FastMath, TheAngleOfEveryQuadrantIsC) {
  for (int i = 0; i < 1000; ++i) {
    const double angle = -3.14159 + 6.28318 * i / 1000;
    const double y = 3 * std::sin(angle), x = 3 * std::cos(angle);
    EXPECT_NEAR(fast::atan2(y, x), std::atan2(y, x), 1e-15);
  }
  for (const double y : {0.0, -0.0, 1.0, -1.0, HUGE_VAL, -HUGE_VAL}) {
    for (const double x : {0.0, -0.0, 1.0, -1.0, HUGE_VAL, -HUGE_VAL}) {
      EXPECT_DOUBLE_EQ(fast::atan2(y, x), std::atan2(y, x)) << y << ' ' << x;
      EXPECT_EQ(std::signbit(fast::atan2(y, x)), std::signbit(std::atan2(y, x))) << y << ' ' << x;
    }
  }
}

TEST(FastMath, EndsOfTheRangesAreWhatTheHeaderSays) {
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(fast::exp(89.0F), infinity);
  EXPECT_EQ(fast::exp(-infinity), 0.0F);
  EXPECT_EQ(fast::exp(-88.0F), 0.0F);
  EXPECT_EQ(fast::exp(0.0F), 1.0F);
  EXPECT_EQ(fast::log(0.0F), -infinity);
  EXPECT_EQ(fast::log(1.0F), 0.0F);
  EXPECT_EQ(fast::log(infinity), infinity);
  EXPECT_TRUE(std::isnan(fast::log(-1.0F)));
  EXPECT_TRUE(std::isnan(fast::exp(std::nanf(""))));
  EXPECT_TRUE(std::isnan(fast::atan2(std::nanf(""), 1.0F)));
  EXPECT_TRUE(std::isnan(fast::pow(-1.0F, 0.5F)));
  EXPECT_EQ(fast::pow(0.0F, 0.0F), 1.0F);
  EXPECT_EQ(fast::pow(0.0F, 2.0F), 0.0F);
  EXPECT_EQ(fast::pow(2.0F, 200.0F), infinity);
  EXPECT_EQ(fast::acos(1.0000001F), 0.0F);
  EXPECT_EQ(fast::acos(-1.0000001F), static_cast<float>(M_PI));
}

/// Every bit of every function over its range. If this changes, pictures change: only on purpose,
/// with the build id.
TEST(FastMath, BitsAreTheOnesOnRecord) {
  std::uint64_t hash = 0;
  const auto add = [&](auto value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof value);
    hash = hash_combine(hash, bits);
  };
  sweep(-1, 1, 10'000, [&](double t) {
    const auto f = static_cast<float>(t);
    const double a = 1e5 * t, e = 700 * t, l = 1 + t + 1e-9;
    add(fast::sin(100 * f)), add(fast::cos(1e5F * f)), add(fast::acos(f)), add(fast::asin(f));
    add(fast::atan(50 * f)), add(fast::atan2(f, 0.3F)), add(fast::exp(87 * f));
    add(fast::log(1.001F + f)), add(fast::pow(1.001F + f, 2.4F));
    add(fast::sin(a)), add(fast::cos(a)), add(fast::acos(t)), add(fast::asin(t));
    add(fast::atan2(t, -0.4)), add(fast::exp(e)), add(fast::log(l));
  });
  EXPECT_EQ(hash, 8221384138616642142ULL);
}

}  // namespace
}  // namespace tessera::render
