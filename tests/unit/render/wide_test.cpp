#include "worker/render/wide.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "tests/unit/render/chi2.hpp"
#include "worker/render/bsdf/energy.hpp"
#include "worker/render/fastmath.hpp"
#include "worker/render/lights/spherical_rectangle.hpp"

namespace tessera::render {
namespace {

template <class T>
bool same_bits(T a, T b) {
  return std::memcmp(&a, &b, sizeof a) == 0 || (std::isnan(a) && std::isnan(b));
}

template <class T>
class WideNumbers : public testing::Test {
 protected:
  /// Ordinary numbers, and those at which operations are special.
  static std::vector<T> numbers() {
    const T infinity = std::numeric_limits<T>::infinity();
    std::vector<T> out{0,
                       T(-0.0),
                       1,
                       -1,
                       T(0.5),
                       T(-7.75),
                       T(3e-20),
                       T(1e20),
                       infinity,
                       -infinity,
                       std::numeric_limits<T>::quiet_NaN()};
    test::Random random(1);
    while (out.size() % Wide<T>::lanes != 0 || out.size() < 64)
      out.push_back(static_cast<T>(random.next()) * 20 - 10);
    return out;
  }
  /// Calls f with each number beside each other one, in all lanes at once.
  template <class F>
  static void each_pair(F&& f) {
    const std::vector<T> all = numbers();
    for (const T b : all)
      for (std::size_t i = 0; i < all.size(); i += Wide<T>::lanes)
        f(Wide<T>::load(&all[i]), Wide<T>(b), &all[i], b);
  }
  static void expect_lanes(const Wide<T>& wide, const T* a, T b, T (*expected)(T, T),
                           const char* what) {
    for (std::size_t lane = 0; lane < Wide<T>::lanes; ++lane)
      EXPECT_TRUE(same_bits(wide[lane], expected(a[lane], b)))
          << what << ' ' << a[lane] << ' ' << b << ": " << wide[lane];
  }
};
using BothWidths = testing::Types<float, double>;
TYPED_TEST_SUITE(WideNumbers, BothWidths);

TYPED_TEST(WideNumbers, AreCountedWithLaneByLane) {
  using T = TypeParam;
  this->each_pair([this](const Wide<T>& x, const Wide<T>& y, const T* a, T b) {
    this->expect_lanes(
        x + y, a, b, [](T p, T q) { return p + q; }, "+");
    this->expect_lanes(
        x - y, a, b, [](T p, T q) { return p - q; }, "-");
    this->expect_lanes(
        x * y, a, b, [](T p, T q) { return p * q; }, "*");
    this->expect_lanes(
        x / y, a, b, [](T p, T q) { return p / q; }, "/");
    this->expect_lanes(
        -x, a, b, [](T p, T) { return -p; }, "negated");
    this->expect_lanes(
        square_root(x), a, b, [](T p, T) { return std::sqrt(p); }, "root");
    this->expect_lanes(
        greater(x, y), a, b, [](T p, T q) { return std::max(p, q); }, "greater");
    this->expect_lanes(
        lesser(x, y), a, b, [](T p, T q) { return std::min(p, q); }, "lesser");
    this->expect_lanes(
        magnitude(x), a, b, [](T p, T) { return std::abs(p); }, "magnitude");
    this->expect_lanes(
        with_sign(x, y), a, b, [](T p, T q) { return std::copysign(p, q); }, "sign");
  });
}

TYPED_TEST(WideNumbers, AreComparedAndSelectedLaneByLane) {
  using T = TypeParam;
  this->each_pair([this](const Wide<T>& x, const Wide<T>& y, const T* a, T b) {
    const auto chosen = [&](const WideMask<T>& mask) {
      return select(mask, Wide<T>(T(1)), Wide<T>(T(2)));
    };
    this->expect_lanes(
        chosen(x < y), a, b, [](T p, T q) -> T { return p < q ? 1 : 2; }, "<");
    this->expect_lanes(
        chosen(x > y), a, b, [](T p, T q) -> T { return p > q ? 1 : 2; }, ">");
    this->expect_lanes(
        chosen(x <= y), a, b, [](T p, T q) -> T { return p <= q ? 1 : 2; }, "<=");
    this->expect_lanes(
        chosen(x >= y), a, b, [](T p, T q) -> T { return p >= q ? 1 : 2; }, ">=");
    const auto zero = Wide<T>(T(0));
    this->expect_lanes(
        chosen((x < y) & (x > zero)), a, b, [](T p, T q) -> T { return p < q && p > 0 ? 1 : 2; },
        "and");
    this->expect_lanes(
        chosen((x < y) | (x > zero)), a, b, [](T p, T q) -> T { return p < q || p > 0 ? 1 : 2; },
        "or");
    this->expect_lanes(
        chosen((x < y) ^ (x > zero)), a, b,
        [](T p, T q) -> T { return (p < q) != (p > 0) ? 1 : 2; }, "either");
  });
}

TEST(Wide, WholePartsAreTowardsZero) {
  const std::array<float, 8> numbers{0, 0.99F, 1, 1.5F, -0.99F, -1.5F, 30.999F, 1e6F};
  const WideFloat wide = whole_part(WideFloat::load(numbers.data()));
  for (std::size_t lane = 0; lane < numbers.size(); ++lane) {
    EXPECT_EQ(wide[lane], std::trunc(numbers[lane]));
    EXPECT_EQ(whole_part(numbers[lane]), std::trunc(numbers[lane]));
  }
}

TEST(Wide, VectorsAreNormalizedAsOneIs) {
  const float huge = 3e30F, nan = std::numeric_limits<float>::quiet_NaN();
  const std::array<Vec3, 8> all{Vec3{},      {1, 2, 3},     {-1e-30F, 0, 0}, {huge, huge, huge},
                                {nan, 0, 1}, {0, -0.0F, 5}, {1e-3F, 1, -1},  {-2, 0.5F, 0}};
  Vector3<WideFloat> wide;
  for (std::size_t lane = 0; lane < all.size(); ++lane) {
    wide.x.set(lane, all[lane].x);
    wide.y.set(lane, all[lane].y);
    wide.z.set(lane, all[lane].z);
  }
  const Vector3<WideFloat> unit = normalize(wide);
  for (std::size_t lane = 0; lane < all.size(); ++lane) {
    const Vec3 one = normalize(all[lane]);
    EXPECT_TRUE(same_bits(unit.x[lane], one.x)) << lane;
    EXPECT_TRUE(same_bits(unit.y[lane], one.y)) << lane;
    EXPECT_TRUE(same_bits(unit.z[lane], one.z)) << lane;
  }
}

TEST(Wide, LostEnergyIsLookedUpAsOfOneDirection) {
  test::Random random(9);
  for (int i = 0; i < 5'000; ++i) {
    std::array<float, 8> cosine{}, alpha{};
    for (std::size_t lane = 0; lane < 8; ++lane) {
      cosine[lane] = random.next();
      alpha[lane] = random.next() * 1.2F;
    }
    cosine[i % 8] = static_cast<float>(i % 2);
    alpha[(i + 3) % 8] = static_cast<float>(i % 3) / 2;
    const WideFloat wide =
        energy::reflection(WideFloat::load(cosine.data()), WideFloat::load(alpha.data()));
    for (std::size_t lane = 0; lane < 8; ++lane)
      ASSERT_TRUE(same_bits(wide[lane], energy::reflection(cosine[lane], alpha[lane])));
  }
  EXPECT_TRUE(std::isnan(energy::reflection(0.5F, std::numeric_limits<float>::quiet_NaN())));
}

TEST(Wide, FloatsFromMemoryAreThemselvesInDouble) {
  const std::array<float, 5> numbers{0.1F, -0.0F, 3e38F, 1e-38F, 7};
  const WideDouble wide = widened(numbers.data());
  for (std::size_t lane = 0; lane < 4; ++lane)
    EXPECT_TRUE(same_bits(wide[lane], static_cast<double>(numbers[lane])));
}

TEST(Wide, SinesAndAnglesHaveTheBitsOfOneNumber) {
  test::Random random(3);
  for (int i = 0; i < 50'000; ++i) {
    std::array<double, 4> x{}, y{};
    const double size = std::pow(10.0, random.next() * 12 - 6);
    for (std::size_t lane = 0; lane < 4; ++lane) {
      x[lane] = (random.next() * 2.0 - 1) * size;
      y[lane] = (random.next() * 2.0 - 1) * size;
    }
    const auto [s, c] = fast::sincos(WideDouble::load(x.data()));
    const auto angle = fast::finite_atan2(WideDouble::load(y.data()), WideDouble::load(x.data()));
    for (std::size_t lane = 0; lane < 4; ++lane) {
      if (std::abs(x[lane]) <= 1e5) {
        const auto [one_s, one_c] = fast::sincos(x[lane]);
        ASSERT_TRUE(same_bits(s[lane], one_s) && same_bits(c[lane], one_c)) << x[lane];
      }
      ASSERT_TRUE(same_bits(angle[lane], fast::atan2(y[lane], x[lane]))) << y[lane] << x[lane];
      ASSERT_TRUE(same_bits(angle[lane], fast::finite_atan2(y[lane], x[lane])));
    }
  }
}

TEST(Wide, RectanglesHaveTheBitsOfOneNumber) {
  test::Random random(4);
  using Vector = Vector3<WideDouble>;
  const auto set = [](Vector& to, std::size_t lane, const Vec3d& from) {
    to.x.set(lane, from.x);
    to.y.set(lane, from.y);
    to.z.set(lane, from.z);
  };
  int wide_angles = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::vector<SphericalRectangle> alone;
    Vector corner, edge_u, edge_v;
    WideDouble u, v;
    for (std::size_t lane = 0; lane < WideDouble::lanes; ++lane) {
      const double size = std::pow(10.0, random.next() * 6 - 3);
      // Every eighth is seen from within its plane.
      const double height = i % 8 == 0 ? 0 : random.next() * 2.0 - 1;
      const Vec3d from{(random.next() - 0.7) * size, (random.next() - 0.7) * size, height};
      const Vec3d along{random.next() * size, 0, 0}, across{0, random.next() * size, 0};
      alone.emplace_back(from, along, across);
      wide_angles += alone.back().solid_angle() > pi_d ? 1 : 0;
      set(corner, lane, from);
      set(edge_u, lane, along);
      set(edge_v, lane, across);
      u.set(lane, random.next());
      v.set(lane, random.next());
    }
    const BasicSphericalRectangle<WideDouble> together(corner, edge_u, edge_v);
    const auto drawn = together.sample(u, v);
    for (std::size_t lane = 0; lane < WideDouble::lanes; ++lane) {
      ASSERT_TRUE(same_bits(together.solid_angle()[lane], alone[lane].solid_angle()));
      const auto one = alone[lane].sample(u[lane], v[lane]);
      ASSERT_TRUE(same_bits(drawn.distance[lane], one.distance));
      ASSERT_TRUE(same_bits(drawn.wi.x[lane], one.wi.x) && same_bits(drawn.wi.y[lane], one.wi.y) &&
                  same_bits(drawn.wi.z[lane], one.wi.z));
    }
  }
  EXPECT_GT(wide_angles, 1000) << "those that the origin stands over were not tried";
}

}  // namespace
}  // namespace tessera::render
