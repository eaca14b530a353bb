#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "worker/render/bsdf/energy.hpp"
#include "worker/render/bsdf/fresnel.hpp"
#include "worker/render/bsdf/ggx.hpp"

/// How the tables of energy.hpp and brushed_energy.hpp are filled: fixed quadratures.
namespace tessera::render::energy {

inline float unwarp_cosine(float x, float alpha) {
  const float y = x * x;
  return std::clamp(2 * alpha * y / (1 + 2 * alpha - y), 1e-5F, 1.0F);
}
inline float unwarp_alpha(float y) { return std::max(y * y, alpha_least); }
inline float coordinate(int i, int side) {
  return static_cast<float>(i) / static_cast<float>(side - 1);
}

/// Points over the normals visible from a direction.
struct NormalGrid {
  int azimuths = 16, heights = 64;
  float part = 0.5F;  ///< of the circle; half of it is enough where the two are alike
};

/// The means of both of f(normal)'s numbers over the normals visible from wo. Midpoints, more of
/// them where normals lie flat: a smooth surface's rare ones are there.
template <class F>
std::array<float, 2> mean_over_normals(const Vec3& wo, const ggx::Roughness& roughness,
                                       const NormalGrid& grid, const F& f) {
  std::array<double, 2> sums{};
  double weights = 0;
  for (int j = 0; j < grid.heights; ++j) {
    const float rest = 1 - (static_cast<float>(j) + 0.5F) / static_cast<float>(grid.heights);
    const double weight = static_cast<double>(rest * rest);
    for (int i = 0; i < grid.azimuths; ++i) {
      const float azimuth =
          grid.part * (static_cast<float>(i) + 0.5F) / static_cast<float>(grid.azimuths);
      const Vec3 m = ggx::sample_visible_normal(roughness, wo, {azimuth, 1 - rest * rest * rest});
      const std::array<float, 2> values = f(m);
      sums[0] += weight * static_cast<double>(values[0]);
      sums[1] += weight * static_cast<double>(values[1]);
    }
    weights += weight * grid.azimuths;
  }
  return {static_cast<float>(sums[0] / weights), static_cast<float>(sums[1] / weights)};
}

inline Vec3 mirrored(const Vec3& wo, const Vec3& m) { return m * (2 * dot(wo, m)) - wo; }

/// What a surface that reflects everything at its microfacets scatters of light to wo at the first
/// bounce.
inline Bounce single_bounce(const Vec3& wo, const ggx::Roughness& roughness,
                            const NormalGrid& grid) {
  const auto leaves = [&](const Vec3& m) -> std::array<float, 2> {
    const Vec3 wi = mirrored(wo, m);
    if (!(wi.z > 0)) return {};
    const float part = ggx::masking_ratio(roughness, wo, wi);
    return {part, part * schlick(std::clamp(dot(wo, m), 0.0F, 1.0F))};
  };
  const std::array<float, 2> means = mean_over_normals(wo, roughness, grid, leaves);
  return {means[0], means[0] > 0 ? means[1] / means[0] : 0};
}

/// 2∫ value(c)·c dc.
template <class F>
float cosine_mean(const F& value) {
  constexpr int n = 512;
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    // Midpoints in √c: the function is steep near 0.
    const float root = (static_cast<float>(i) + 0.5F) / n;
    const float cosine = root * root;
    sum += static_cast<double>(value(cosine)) * static_cast<double>(4 * cosine * root);
  }
  return static_cast<float>(sum / n);
}

}  // namespace tessera::render::energy
