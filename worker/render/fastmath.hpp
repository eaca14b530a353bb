#pragma once
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <utility>

#include "worker/render/wide.hpp"

/// Elementary functions without the C library, whose results depend on the CPU it finds itself on.
/// Only + − × ÷, sqrt, comparisons and bit operations in a fixed order, so the bits are the same
/// everywhere (given -ffp-contract=off).
///
/// Bounds, asserted by tests against libm in double: float functions err by at most 0.52 units in
/// the last place, in the ranges given with each; double functions by at most 4·2^-52 relative
/// (sin, cos: absolute). Results below the least normal number are 0. NaN gives NaN.
namespace tessera::render::fast {

namespace detail {

/// c[First] + c[First + 1]·x + … + c[First + Count − 1]·x^(Count − 1), in halves (Estrin): a chain
/// of operations a third as long as Horner's.
template <std::size_t First, std::size_t Count, std::size_t Terms, class N>
constexpr N polynomial_part(N x, const double (&c)[Terms]) {
  if constexpr (Count == 1) {
    return c[First];
  } else if constexpr (Count == 2) {
    return c[First] + c[First + 1] * x;
  } else {
    constexpr std::size_t low = std::bit_ceil(Count) / 2;
    N power = x;
    for (std::size_t n = 1; n < low; n *= 2) power *= power;
    return polynomial_part<First, low>(x, c) +
           polynomial_part<First + low, Count - low>(x, c) * power;
  }
}
template <std::size_t Count, std::size_t Terms, class N>
constexpr N polynomial(N x, const double (&c)[Terms]) {
  static_assert(Count <= Terms);
  return polynomial_part<0, Count>(x, c);
}

// Taylor series: after the reductions below they converge fast enough to be as short as fitted
// ones, and anyone can check them. The float functions take fewer terms.
constexpr double sin_terms[] = {1.0,
                                -1.0 / 6,
                                1.0 / 120,
                                -1.0 / 5040,
                                1.0 / 362880,
                                -1.0 / 39916800,
                                1.0 / 6227020800.0,
                                -1.0 / 1307674368000.0,
                                1.0 / 355687428096000.0};
constexpr double cos_terms[] = {1.0,
                                -1.0 / 2,
                                1.0 / 24,
                                -1.0 / 720,
                                1.0 / 40320,
                                -1.0 / 3628800,
                                1.0 / 479001600,
                                -1.0 / 87178291200.0,
                                1.0 / 20922789888000.0};
constexpr double exp_terms[] = {1.0,
                                1.0,
                                1.0 / 2,
                                1.0 / 6,
                                1.0 / 24,
                                1.0 / 120,
                                1.0 / 720,
                                1.0 / 5040,
                                1.0 / 40320,
                                1.0 / 362880,
                                1.0 / 3628800,
                                1.0 / 39916800,
                                1.0 / 479001600,
                                1.0 / 6227020800.0};
/// atanh(s)/s and, with alternating signs, atan(r)/r, in powers of the square.
constexpr double atanh_terms[] = {1.0,      1.0 / 3,  1.0 / 5,  1.0 / 7,  1.0 / 9, 1.0 / 11,
                                  1.0 / 13, 1.0 / 15, 1.0 / 17, 1.0 / 19, 1.0 / 21};
constexpr double atan_terms[] = {1.0,       -1.0 / 3, 1.0 / 5,   -1.0 / 7, 1.0 / 9,
                                 -1.0 / 11, 1.0 / 13, -1.0 / 15, 1.0 / 17};

/// How many terms serve each precision.
template <class T>
struct Terms {
  static constexpr std::size_t sin = 9, cos = 9, exp = 14, atanh = 11, atan = 9;
};
template <>
struct Terms<float> {
  static constexpr std::size_t sin = 6, cos = 6, exp = 9, atanh = 6, atan = 5;
};

/// A number of |x| < 2^51 that is added to it has its nearest whole number (ties to even, in the
/// default rounding mode) in the sum's last bits.
constexpr double whole_numbers = 0x1.8p52;
constexpr double round_near(double x) { return (x + whole_numbers) - whole_numbers; }

/// |r| ≤ π/4.
template <class T, class N>
std::pair<N, N> sincos_reduced(N r) {
  const N r2 = r * r;
  return {r * polynomial<Terms<T>::sin>(r2, sin_terms), polynomial<Terms<T>::cos>(r2, cos_terms)};
}

template <class T, class N>
std::pair<N, N> sincos_of(N x) {
  // π/2 in three parts of at most 33 bits, so that n times each of the first two is exact (Cody and
  // Waite).
  constexpr double part1 = 0x1.921fb544p+0, part2 = 0x1.0b4611a6p-34, part3 = 0x1.3198a2e037073p-69;
  const N shifted = x * 0.63661977236758134308 + whole_numbers;
  const N n = shifted - whole_numbers;
  const N r = ((x - n * part1) - n * part2) - n * part3;
  const auto [s, c] = sincos_reduced<T>(r);
  // The quadrant's two bits.
  const auto odd = has_bit(shifted, 0), second = has_bit(shifted, 1);
  const N sin_x = select(odd, c, s), cos_x = select(odd, s, c);
  return {select(second, -sin_x, sin_x), select(odd ^ second, -cos_x, cos_x)};
}

template <class T>
double exp_of(double x) {
  const double n = round_near(x * 1.44269504088896340736);
  // ln 2 in two parts; n times the first is exact.
  const double r = (x - n * 0x1.62e42feep-1) - n * 0x1.a39ef35793c76p-33;
  const double scale =
      std::bit_cast<double>(static_cast<std::uint64_t>(static_cast<std::int64_t>(n) + 1023) << 52);
  return polynomial<Terms<T>::exp>(r, exp_terms) * scale;
}

/// x > 0 and normal.
template <class T>
double log_of(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  // Subtracting sqrt(1/2) from the mantissa's bits puts the mantissa within [sqrt(1/2), sqrt(2)).
  constexpr std::uint64_t low = std::bit_cast<std::uint64_t>(0x1.6a09e667f3bcdp-1);
  const std::int64_t exponent = static_cast<std::int64_t>(bits - low) >> 52;
  const double m = std::bit_cast<double>(bits - (static_cast<std::uint64_t>(exponent) << 52));
  const double s = (m - 1) / (m + 1);
  const double fraction = 2 * s * polynomial<Terms<T>::atanh>(s * s, atanh_terms);
  const auto e = static_cast<double>(exponent);
  return e * 0x1.62e42feep-1 + (fraction + e * 0x1.a39ef35793c76p-33);
}

/// Angle of (x, y) for 0 ≤ y ≤ x, 0 < x.
template <class T, class N>
N atan_of_ratio(N y, N x) {
  // atan(y/x) = atan(c) + atan((y − c·x)/(x + c·y)) with c the nearest quarter: the remainder is at
  // most 1/8.
  constexpr double atan_quarters[] = {0, 0.24497866312686415417, 0.46364760900080611621,
                                      0.64350110879328438680, 0.78539816339744830962};
  const N y8 = 8.0 * y;
  N c = 0.0, quarter = 0.0;
  for (std::size_t i = 1; i < std::size(atan_quarters); ++i) {
    const auto above = y8 > static_cast<double>(2 * i - 1) * x;
    c = select(above, N(0.25 * static_cast<double>(i)), c);
    quarter = select(above, N(atan_quarters[i]), quarter);
  }
  const N r = (y - c * x) / (x + c * y);
  return quarter + r * polynomial<Terms<T>::atan>(r * r, atan_terms);
}

/// The angle of (x, y) where both are finite and not both 0; else any number, or NaN.
template <class T, class N>
N finite_atan2(N y, N x) {
  // Selections, not branches: which octant it is cannot be foretold.
  const N ay = with_sign(y, N(1.0)), ax = with_sign(x, N(1.0));
  const auto steep = ay > ax;
  const N angle = atan_of_ratio<T>(select(steep, ax, ay), select(steep, ay, ax));
  const N acute = select(steep, 1.57079632679489661923 - angle, angle);
  return with_sign(select(x < 0.0, 3.14159265358979323846 - acute, acute), y);
}

template <class T>
double atan2_of(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return x + y;
  if (x == 0 && y == 0) return std::copysign(std::signbit(x) ? 3.14159265358979323846 : 0.0, y);
  if (std::isinf(x)) {
    y = std::copysign(std::isinf(y) ? 1.0 : 0.0, y);
    x = std::copysign(1.0, x);
  } else if (std::isinf(y)) {
    x = 0;
    y = std::copysign(1.0, y);
  }
  return finite_atan2<T>(y, x);
}

}  // namespace detail

/// Sine and cosine of an angle in radians, |x| ≤ 1e5 (float and double); beyond it the error grows
/// with x, and from 3.5e15 on it is no sine at all.
inline std::pair<float, float> sincos(float x) {
  const auto [s, c] = detail::sincos_of<float>(static_cast<double>(x));
  return {static_cast<float>(s), static_cast<float>(c)};
}
/// The same for |x| ≤ π/4, with the same bits, in less time.
inline std::pair<float, float> sincos_near_zero(float x) {
  const auto [s, c] = detail::sincos_reduced<float>(static_cast<double>(x));
  return {static_cast<float>(s), static_cast<float>(c)};
}
inline std::pair<double, double> sincos(double x) { return detail::sincos_of<double>(x); }
inline std::pair<WideDouble, WideDouble> sincos(const WideDouble& x) {
  return detail::sincos_of<double>(x);
}
inline float sin(float x) { return sincos(x).first; }
inline float cos(float x) { return sincos(x).second; }
inline double sin(double x) { return sincos(x).first; }
inline double cos(double x) { return sincos(x).second; }

/// The angle of (x, y), −π … π. atan2(±0, +0) is ±0, atan2(±0, −0) is ±π, as in C.
inline float atan2(float y, float x) { return static_cast<float>(detail::atan2_of<float>(y, x)); }
inline double atan2(double y, double x) { return detail::atan2_of<double>(y, x); }
/// The same where both are finite and not both 0; else any number, or NaN.
inline double finite_atan2(double y, double x) { return detail::finite_atan2<double>(y, x); }
inline WideDouble finite_atan2(const WideDouble& y, const WideDouble& x) {
  return detail::finite_atan2<double>(y, x);
}
inline float atan(float x) { return atan2(x, 1.0F); }
inline double atan(double x) { return atan2(x, 1.0); }

/// x is clamped to −1 … 1 first: what comes here is a cosine with its rounding errors.
inline double acos(double x) {
  const double c = x < -1 ? -1 : (x > 1 ? 1 : x);
  return detail::atan2_of<double>(std::sqrt((1 - c) * (1 + c)), c);
}
inline double asin(double x) {
  const double s = x < -1 ? -1 : (x > 1 ? 1 : x);
  return detail::atan2_of<double>(s, std::sqrt((1 - s) * (1 + s)));
}
inline float acos(float x) {
  const double c = x < -1 ? -1 : (x > 1 ? 1 : x);
  return static_cast<float>(detail::atan2_of<float>(std::sqrt((1 - c) * (1 + c)), c));
}
inline float asin(float x) {
  const double s = x < -1 ? -1 : (x > 1 ? 1 : x);
  return static_cast<float>(detail::atan2_of<float>(s, std::sqrt((1 - s) * (1 + s))));
}

/// e^x; +Inf where it is too large, 0 where it is below the least normal number.
inline float exp(float x) {
  if (std::isnan(x)) return x;
  if (x > 88.72283F) return std::numeric_limits<float>::infinity();
  if (x < -87.33654F) return 0;
  return static_cast<float>(detail::exp_of<float>(x));
}
inline double exp(double x) {
  if (std::isnan(x)) return x;
  if (x > 709.0) return std::numeric_limits<double>::infinity();
  if (x < -708.0) return 0;
  return detail::exp_of<double>(x);
}

/// Natural logarithm; −Inf of 0 (and of what is below the least normal number), NaN of what is
/// negative.
inline double log(double x) {
  if (!(x >= 0)) return std::numeric_limits<double>::quiet_NaN();
  if (x < std::numeric_limits<double>::min()) return -std::numeric_limits<double>::infinity();
  if (std::isinf(x)) return x;
  return detail::log_of<double>(x);
}
inline float log(float x) {
  if (!(x >= 0)) return std::numeric_limits<float>::quiet_NaN();
  if (x < std::numeric_limits<float>::min()) return -std::numeric_limits<float>::infinity();
  if (std::isinf(x)) return x;
  return static_cast<float>(detail::log_of<float>(x));
}

/// base^exponent for base ≥ 0; 0^0 is 1, as in C. NaN where the base is negative.
inline float pow(float base, float exponent) {
  if (exponent == 0) return 1;
  if (base == 0) return exponent > 0 ? 0 : std::numeric_limits<float>::infinity();
  // In double, so that the exponent does not magnify the logarithm's error into the float's digits.
  const double power = static_cast<double>(exponent) * log(static_cast<double>(base));
  if (power > 88.72283) return std::numeric_limits<float>::infinity();
  if (power < -87.33654) return 0;
  return std::isnan(power) ? std::numeric_limits<float>::quiet_NaN()
                           : static_cast<float>(detail::exp_of<float>(power));
}

}  // namespace tessera::render::fast
