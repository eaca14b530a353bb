#pragma once
#include <algorithm>
#include <cmath>

#include "worker/render/fastmath.hpp"
#include "worker/render/vec.hpp"

/// From the unit square to other shapes, each with the density of its result. All keep neighbours
/// together, so that stratified input stays stratified.
namespace tessera::render {

/// Uniform on the unit disk. Shirley and Chiu, "A Low Distortion Map Between Disk and Square",
/// 1997.
inline Vec2 square_to_disk(Vec2 u) {
  const float a = 2 * u.x - 1, b = 2 * u.y - 1;
  if (a == 0 && b == 0) return {};
  // Selections, not branches: which triangle of the square it is cannot be foretold.
  const bool x_major = std::abs(a) > std::abs(b);
  const float radius = x_major ? a : b, other = x_major ? b : a;
  // From the nearer axis; seen from the other one, sine and cosine change places.
  const auto [sin_angle, cos_angle] = fast::sincos_near_zero((pi / 4) * (other / radius));
  return {radius * (x_major ? cos_angle : sin_angle), radius * (x_major ? sin_angle : cos_angle)};
}
constexpr float disk_pdf() { return inv_pi; }

/// On the upper hemisphere, density cos θ / π. Malley's method: a disk sample, lifted.
inline Vec3 square_to_cosine_hemisphere(Vec2 u) {
  const Vec2 d = square_to_disk(u);
  // Never below the least normal square, so that the cosine that divides elsewhere is not 0.
  const float z = std::sqrt(std::max(1e-12F, 1 - d.x * d.x - d.y * d.y));
  return {d.x, d.y, z};
}
inline float cosine_hemisphere_pdf(const Vec3& v) { return v.z > 0 ? v.z * inv_pi : 0; }

/// Uniform on the sphere (Archimedes: height and azimuth).
inline Vec3 square_to_sphere(Vec2 u) {
  const float z = 1 - 2 * u.x;
  // 1 − z² without cancellation.
  const float r = std::sqrt(4 * u.x * (1 - u.x));
  const auto [s, c] = fast::sincos(2 * pi * u.y);
  return {r * c, r * s, z};
}
constexpr float sphere_pdf() { return 0.25F * inv_pi; }

/// Uniform on the upper hemisphere.
inline Vec3 square_to_hemisphere(Vec2 u) {
  const float r = std::sqrt(u.x * (2 - u.x));
  const auto [s, c] = fast::sincos(2 * pi * u.y);
  return {r * c, r * s, 1 - u.x};
}
inline float hemisphere_pdf(const Vec3& v) { return v.z > 0 ? 0.5F * inv_pi : 0; }

/// Barycentric coordinates (of the second and third vertex), uniform on the triangle. Heitz, "A
/// Low-Distortion Map Between Triangle and Square", 2019.
inline Vec2 square_to_triangle(Vec2 u) {
  if (u.y > u.x) {
    const float x = u.x * 0.5F;
    return {x, u.y - x};
  }
  const float y = u.y * 0.5F;
  return {u.x - y, y};
}
/// Per unit of the (b1, b2) plane.
constexpr float triangle_pdf() { return 2; }

}  // namespace tessera::render
