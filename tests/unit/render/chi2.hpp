#pragma once
#include <cstddef>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "worker/render/vec.hpp"

namespace tessera::render::test {

/// Independent numbers in [0, 1)², for tests whose statistics need independence.
class Random {
 public:
  explicit Random(std::uint32_t seed) : generator_(seed) {}
  float next() { return static_cast<float>(generator_() >> 8) * 0x1p-24F; }
  Vec2 next2() {
    const float x = next();
    const float y = next();
    return {x, y};
  }
  std::uint32_t bits() { return static_cast<std::uint32_t>(generator_()); }

 private:
  std::mt19937 generator_;
};

/// The chance that chi² with so many degrees of freedom is at least `value`.
double chi2_tail(double value, double degrees);

/// How a sample() is held against its pdf() over the unit square, into which the caller maps what
/// was sampled.
struct Chi2Case {
  /// A sample, where it lies in the square; nothing if sample() gave nothing. Must fail the test
  /// itself where pdf is 0.
  std::function<std::optional<Vec2>(Random&)> sample;
  /// The density per unit of the square, by pdf().
  std::function<double(double s, double t)> density;
  int bins_s = 16, bins_t = 16;
  int samples = 1'000'000;
  /// Each bin is cut into this many, squared, before Gauss' rule of 5×5 points.
  int quadrature = 4;
};

/// An empty string if the hypothesis stands at α = .01 (with Šidák's correction for all tests of
/// this folder), else why it falls. Bins that expect less than 5 are pooled; the density must
/// integrate to at most 1, the rest being "nothing".
std::string chi2_test(const Chi2Case& test, std::uint32_t seed = 1);

/// The same for counts against expected counts.
std::string chi2_compare(const std::vector<double>& observed, const std::vector<double>& expected);

}  // namespace tessera::render::test
