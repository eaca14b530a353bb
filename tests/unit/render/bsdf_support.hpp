#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "tests/unit/render/chi2.hpp"
#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/warp.hpp"

/// What the tests of lobes share.
namespace tessera::render::test {

inline Closure closure_of(std::initializer_list<Lobe> lobes, const Vec3& normal = {0, 0, 1}) {
  Closure closure;
  closure.clear();
  closure.normal = normal;
  closure.shading = Frame(normal);
  for (const Lobe& lobe : lobes) closure.add(lobe);
  return closure;
}

/// The greatest difference of a channel.
inline double distance(const Color& a, const Color& b) {
  return static_cast<double>(
      std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)}));
}

inline Vec3 from_angles(float cos_theta, float azimuth) {
  const float s = std::sqrt(1 - cos_theta * cos_theta);
  return {s * std::cos(azimuth), s * std::sin(azimuth), cos_theta};
}

/// All directions: (1 + cos θ)/2 against the shading normal, and the azimuth. Delta lobes count as
/// nothing.
inline Chi2Case directions(const Closure& closure, const Vec3& wo) {
  Chi2Case test;
  test.bins_s = 20;
  test.sample = [closure, wo](Random& random) -> std::optional<Vec2> {
    const float u_lobe = random.next();
    const BsdfSample drawn = sample(closure, wo, u_lobe, random.next2());
    if (!drawn || drawn.specular) return std::nullopt;
    EXPECT_GT(pdf(closure, wo, drawn.wi), 0);
    EXPECT_NEAR(drawn.pdf, pdf(closure, wo, drawn.wi), 1e-4F * drawn.pdf + 1e-6F);
    // The weight is f·cos/pdf, cosine included.
    const Color f = eval(closure, wo, drawn.wi);
    EXPECT_LT(distance(f, drawn.weight * drawn.pdf),
              1e-4 * static_cast<double>(max_component(f)) + 1e-6);
    const Vec3 local = closure.shading.to_local(drawn.wi);
    const float azimuth = std::atan2(local.y, local.x) / (2 * pi);
    return Vec2{0.5F * (1 + local.z), azimuth < 0 ? azimuth + 1 : azimuth};
  };
  test.density = [closure, wo](double s, double t) {
    const double z = 2 * s - 1, r = std::sqrt(std::max(0.0, 1 - z * z));
    const Vec3d local{r * std::cos(2 * M_PI * t), r * std::sin(2 * M_PI * t), z};
    return 4 * M_PI *
           static_cast<double>(pdf(closure, wo, closure.shading.to_world(to_float(local))));
  };
  return test;
}

/// What comes back of light 1 from everywhere, as energy (without radiance's squeeze), by
/// stratified samples; with its standard error.
struct Furnace {
  double mean = 0, error = 0;  ///< of green
  Color all;
};
inline Furnace furnace(const Closure& closure, const Vec3& wo, int side = 300) {
  Random random(9);
  double sum = 0, squares = 0;
  Color all;
  const int n = side * side;
  for (int i = 0; i < n; ++i) {
    const float x = (static_cast<float>(i % side) + random.next()) / static_cast<float>(side);
    const float y = (static_cast<float>(i / side) + random.next()) / static_cast<float>(side);
    const float u_lobe = random.next();
    const BsdfSample drawn = sample(closure, wo, u_lobe, {x, y});
    if (!drawn) continue;
    const double value = static_cast<double>(drawn.weight.g * drawn.eta * drawn.eta);
    sum += value / n;
    squares += value * value / n;
    all += drawn.weight * (drawn.eta * drawn.eta / static_cast<float>(n));
  }
  return {sum, std::sqrt(std::max(0.0, squares - sum * sum) / n), all};
}

}  // namespace tessera::render::test
