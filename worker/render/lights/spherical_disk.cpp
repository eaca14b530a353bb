#include "worker/render/lights/spherical_disk.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "worker/render/frame.hpp"
#include "worker/render/hash.hpp"
#include "worker/render/lights/spherical_rectangle.hpp"

namespace tessera::render {
namespace {

/// ∫ (cos²φ + b·sin²φ) / (cos²φ + p²·sin²φ) / √(cos²φ + kc²·sin²φ) dφ over 0 … π/2, for p, kc > 0.
/// Bulirsch's general complete elliptic integral, by arithmetic-geometric means ("Numerical
/// Calculation of Elliptic Integrals and Elliptic Functions", Numerische Mathematik 7, 1965).
double elliptic_integral(double kc, double p, double b) {
  constexpr double accuracy = 1e-8;  // its square is that of the result
  double a = 1, product = kc, mean = 1;
  b /= p;
  for (;;) {
    const double before = a, ratio = product / p;
    a += b / p;
    b = 2 * (b + before * ratio);
    p += ratio;
    const double last = mean;
    mean += kc;
    if (std::abs(last - kc) <= last * accuracy) break;
    kc = 2 * std::sqrt(product);
    product = kc * mean;
  }
  return pi_d / 2 * (b + a * mean) / (mean * (mean + p));
}

}  // namespace

SphericalDisk::SphericalDisk(const Vec3d& center, const Vec3d& normal, double radius)
    : center_(center),
      normal_(normal),
      radius_(radius),
      aside_(center - normal * dot(center, normal)),
      height_(std::abs(dot(center, normal))),
      beside_(length(aside_)) {}

double SphericalDisk::solid_angle() const {
  // Paxton, "Solid Angle Calculation for a Circular Disk", 1959, its two elliptic integrals as one.
  if (!(height_ > 0)) return 0;
  const double sum = radius_ + beside_, difference = radius_ - beside_;
  const double farthest = std::sqrt(height_ * height_ + sum * sum);
  const double nearest = std::sqrt(height_ * height_ + difference * difference);
  // Over the rim itself: a step aside that is beyond what positions are known by.
  const double c = std::abs(difference) > 1e-12 * sum ? difference / sum : 1e-12;
  const double rim =
      2 * height_ / farthest * (1 + c) * elliptic_integral(nearest / farthest, std::abs(c), c);
  return std::clamp((c > 0 ? 2 * pi_d : 0) - rim, 0.0, 2 * pi_d);
}

SphericalDisk::Sample SphericalDisk::sample(Vec2 u) const {
  constexpr int tries = 64;
  const Vec3d across = beside_ > 1e-9 * radius_ ? aside_ / beside_ : FrameD(normal_).s;
  const Vec3d along = cross(normal_, across);
  const SphericalRectangle around(center_ - (across + along) * radius_, across * (2 * radius_),
                                  along * (2 * radius_));
  double s = u.x, t = u.y;
  std::uint64_t bits =
      hash_combine(std::bit_cast<std::uint32_t>(u.x), std::bit_cast<std::uint32_t>(u.y));
  for (int i = 0; i < tries; ++i) {
    const SphericalRectangle::Sample drawn = around.sample(s, t);
    const Vec3d off = drawn.wi * drawn.distance - center_;
    if (length_squared(off) <= radius_ * radius_) return {drawn.wi, drawn.distance};
    bits = mix64(bits + 0x9e3779b97f4a7c15ULL);
    s = static_cast<double>(bits >> 32) * 0x1p-32;
    t = static_cast<double>(bits & 0xffffffffU) * 0x1p-32;
  }
  return {{}, 0};
}

}  // namespace tessera::render
