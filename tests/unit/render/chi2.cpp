#include "tests/unit/render/chi2.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace tessera::render::test {

namespace {

constexpr int tests_in_folder = 100;

/// Lower regularised incomplete gamma function by its series, for x < a + 1.
double gamma_series(double a, double x) {
  double term = 1 / a, sum = term;
  for (int n = 1; n < 100'000 && term > sum * 1e-15; ++n) {
    term *= x / (a + n);
    sum += term;
  }
  return sum * std::exp(-x + a * std::log(x) - std::lgamma(a));
}

/// Upper one by its continued fraction (Lentz), for x ≥ a + 1.
double gamma_fraction(double a, double x) {
  double b = x + 1 - a, c = 1e300, d = 1 / b, h = d;
  for (int n = 1; n < 100'000; ++n) {
    const double an = -n * (n - a);
    b += 2;
    d = 1 / (an * d + b);
    c = b + an / c;
    h *= d * c;
    if (std::abs(d * c - 1) < 1e-15) break;
  }
  return h * std::exp(-x + a * std::log(x) - std::lgamma(a));
}

double integrate(const Chi2Case& test, double s0, double t0, double ds, double dt) {
  static constexpr double node[5] = {0.04691007703066800, 0.23076534494715845, 0.5,
                                     0.76923465505284155, 0.95308992296933200};
  static constexpr double weight[5] = {0.11846344252809454, 0.23931433524968324,
                                       0.28444444444444444, 0.23931433524968324,
                                       0.11846344252809454};
  const int q = test.quadrature;
  double sum = 0;
  for (int cell = 0; cell < q * q; ++cell) {
    const int row = cell / q, column = cell % q;
    for (int i = 0; i < 5; ++i) {
      for (int j = 0; j < 5; ++j) {
        const double s = s0 + ds * (row + node[i]) / q;
        const double t = t0 + dt * (column + node[j]) / q;
        sum += weight[i] * weight[j] * test.density(s, t);
      }
    }
  }
  return sum * ds * dt / (q * q);
}

}  // namespace

double chi2_tail(double value, double degrees) {
  const double a = degrees / 2, x = value / 2;
  if (x <= 0) return 1;
  return x < a + 1 ? 1 - gamma_series(a, x) : gamma_fraction(a, x);
}

std::string chi2_compare(const std::vector<double>& observed, const std::vector<double>& expected) {
  std::vector<std::size_t> order(expected.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return expected[a] < expected[b]; });
  double chi2 = 0, pooled_observed = 0, pooled_expected = 0;
  int cells = 0;
  const auto count = [&](double o, double e) {
    chi2 += (o - e) * (o - e) / e;
    ++cells;
  };
  for (const std::size_t i : order) {
    if (expected[i] <= 1e-9) {
      if (observed[i] > 0) {
        return fmt::format("{} samples in bin {}, where none belongs", observed[i], i);
      }
    } else if (expected[i] < 5 || (pooled_expected > 0 && pooled_expected < 5)) {
      pooled_observed += observed[i];
      pooled_expected += expected[i];
    } else {
      count(observed[i], expected[i]);
    }
  }
  if (pooled_expected > 0) count(pooled_observed, pooled_expected);
  if (cells < 2) return "too few bins to say anything";
  const double p = chi2_tail(chi2, cells - 1);
  const double alpha = 1 - std::pow(1 - 0.01, 1.0 / tests_in_folder);
  return p >= alpha ? std::string()
                    : fmt::format("chi² {:.1f} with {} degrees of freedom: p = {:.3g}", chi2,
                                  cells - 1, p);
}

std::string chi2_test(const Chi2Case& test, std::uint32_t seed) {
  const auto bins = static_cast<std::size_t>(test.bins_s) * static_cast<std::size_t>(test.bins_t);
  std::vector<double> observed(bins + 1, 0.0), expected(bins + 1, 0.0);  // the last one: nothing
  Random random(seed);
  for (int i = 0; i < test.samples; ++i) {
    const std::optional<Vec2> point = test.sample(random);
    std::size_t bin = bins;
    if (point) {
      const int s = std::clamp(static_cast<int>(point->x * static_cast<float>(test.bins_s)), 0,
                               test.bins_s - 1);
      const int t = std::clamp(static_cast<int>(point->y * static_cast<float>(test.bins_t)), 0,
                               test.bins_t - 1);
      bin = static_cast<std::size_t>(s) * static_cast<std::size_t>(test.bins_t) +
            static_cast<std::size_t>(t);
    }
    observed[bin] += 1;
  }
  double total = 0;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    const double ds = 1.0 / test.bins_s, dt = 1.0 / test.bins_t;
    const std::size_t row = bin / static_cast<std::size_t>(test.bins_t);
    const std::size_t column = bin % static_cast<std::size_t>(test.bins_t);
    const auto s = static_cast<double>(row), t = static_cast<double>(column);
    const double mass = integrate(test, s * ds, t * dt, ds, dt);
    expected[bin] = mass * test.samples;
    total += mass;
  }
  if (total > 1 + 1e-4) return fmt::format("the density integrates to {:.6f}", total);
  expected[bins] = total > 1 - 1e-4 ? 0 : (1 - total) * test.samples;
  return chi2_compare(observed, expected);
}

}  // namespace tessera::render::test
