#pragma once
#include <algorithm>
#include <cmath>

#include "worker/render/fastmath.hpp"
#include "worker/render/vec.hpp"

/// The GGX distribution of microfacets (Walter et al. 2007), anisotropic, under Smith's masking.
/// Directions are in the shading frame; where a side matters it is the upper one, z > 0.
namespace tessera::render::ggx {

/// Below this α a surface is taken to be smooth.
inline constexpr float alpha_smooth = 1e-4F;

template <class N>
struct BasicRoughness {
  N alpha_x = 1, alpha_y = 1;
};
using Roughness = BasicRoughness<float>;

inline bool is_smooth(const Roughness& r) { return std::max(r.alpha_x, r.alpha_y) < alpha_smooth; }

/// √(z² + αx²x² + αy²y²): the length of v as the stretched surface sees it.
template <class N>
N stretched(const BasicRoughness<N>& r, const Vector3<N>& v) {
  const N x = r.alpha_x * v.x, y = r.alpha_y * v.y;
  return square_root(v.z * v.z + x * x + y * y);
}

/// D(m) = 1 / (π·αx·αy·e²) with e = (x/αx)² + (y/αy)² + z², per projected area, for a unit normal
/// m. By one division, as all of it is multiplied by αx·αy.
template <class N>
N distribution(const BasicRoughness<N>& r, const Vector3<N>& m) {
  const N area = r.alpha_x * r.alpha_y;
  const N x = r.alpha_y * m.x, y = r.alpha_x * m.y, z = area * m.z;
  const N e = x * x + y * y + z * z;
  return area * area * area / (pi * e * e);
}

/// G1(v) / |v.z|.
template <class N>
N masking_over_cosine(const BasicRoughness<N>& r, const Vector3<N>& v) {
  return 2.0F / (magnitude(v.z) + stretched(r, v));
}
/// G2(a, b) / (|a.z|·|b.z|), height-correlated (Heitz 2014): 1 / (1 + Λ(a) + Λ(b)).
template <class N>
N masking_over_cosines(const BasicRoughness<N>& r, const Vector3<N>& a, const Vector3<N>& b) {
  return 2.0F / (stretched(r, a) * magnitude(b.z) + stretched(r, b) * magnitude(a.z));
}
/// G2 / G1(a): what of b's light is left when m was drawn as seen from a.
inline float masking_ratio(const Roughness& r, const Vec3& a, const Vec3& b) {
  const float za = std::abs(a.z), zb = std::abs(b.z), sa = stretched(r, a);
  return zb * (za + sa) / (sa * zb + stretched(r, b) * za);
}

/// A normal as seen from v, v.z ≥ 0: density D·G1·max(0, v·m) / v.z. By spherical caps (Dupuy and
/// Benyoub, "Sampling Visible GGX Normals with Spherical Caps", 2023).
inline Vec3 sample_visible_normal(const Roughness& r, const Vec3& v, Vec2 u) {
  const Vec3 w = normalize(Vec3{r.alpha_x * v.x, r.alpha_y * v.y, v.z});
  const auto [s, c] = fast::sincos(2 * pi * u.x);
  const float z = (1 - u.y) * (1 + w.z) - w.z;
  const float radius = std::sqrt(std::clamp(1 - z * z, 0.0F, 1.0F));
  const Vec3 h{radius * c + w.x, radius * s + w.y, z + w.z};
  return normalize(Vec3{r.alpha_x * h.x, r.alpha_y * h.y, std::max(h.z, 0.0F)});
}
inline float visible_normal_pdf(const Roughness& r, const Vec3& v, const Vec3& m) {
  return distribution(r, m) * masking_over_cosine(r, v) * std::abs(dot(v, m));
}

}  // namespace tessera::render::ggx
