#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "worker/render/wide.hpp"

/// Plain vectors and colours. Float where light is carried, double where transforms are composed or
/// solid angles measured. std::sqrt and std::abs are the only functions of the C library used here:
/// both are exact.
namespace tessera::render {

/// A point of the unit square, or texture coordinates.
struct Vec2 {
  float x = 0, y = 0;
  bool operator==(const Vec2&) const = default;
};

/// A point, direction or normal; the name of the variable says which.
template <class T>
struct Vector3 {
  T x = 0, y = 0, z = 0;
  bool operator==(const Vector3&) const = default;

  constexpr Vector3 operator-() const { return {-x, -y, -z}; }
  constexpr Vector3& operator+=(const Vector3& b) { return *this = {x + b.x, y + b.y, z + b.z}; }
  constexpr Vector3& operator-=(const Vector3& b) { return *this = {x - b.x, y - b.y, z - b.z}; }
  constexpr Vector3& operator*=(T s) { return *this = {x * s, y * s, z * s}; }
  friend constexpr Vector3 operator+(const Vector3& a, const Vector3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend constexpr Vector3 operator-(const Vector3& a, const Vector3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend constexpr Vector3 operator*(const Vector3& a, T s) { return {a.x * s, a.y * s, a.z * s}; }
  friend constexpr Vector3 operator*(T s, const Vector3& a) { return a * s; }
  friend constexpr Vector3 operator/(const Vector3& a, T s) { return {a.x / s, a.y / s, a.z / s}; }
};
using Vec3 = Vector3<float>;
using Vec3d = Vector3<double>;

constexpr Vec3d to_double(const Vec3& v) { return {v.x, v.y, v.z}; }
constexpr Vec3 to_float(const Vec3d& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
constexpr Vec3d to_vec3d(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

template <class T>
constexpr T dot(const Vector3<T>& a, const Vector3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
constexpr Vector3<T> cross(const Vector3<T>& a, const Vector3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
constexpr T length_squared(const Vector3<T>& v) {
  return dot(v, v);
}
template <class T>
T length(const Vector3<T>& v) {
  return square_root(dot(v, v));
}
/// v / |v|. The zero vector, and one whose length is no number, give the zero vector.
template <class T>
Vector3<T> normalize(const Vector3<T>& v) {
  const T l = length(v);
  return l > 0 ? v * (T(1) / l) : Vector3<T>{};
}
template <class T>
Vector3<Wide<T>> normalize(const Vector3<Wide<T>>& v) {
  const Wide<T> l = length(v), inverse = T(1) / l, none = T(0);
  const auto some = l > none;
  return {select(some, v.x * inverse, none), select(some, v.y * inverse, none),
          select(some, v.z * inverse, none)};
}
inline bool is_finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Linear Rec.709: a radiance, a throughput or an albedo.
struct Color {
  float r = 0, g = 0, b = 0;
  bool operator==(const Color&) const = default;

  constexpr Color& operator+=(const Color& c) { return *this = {r + c.r, g + c.g, b + c.b}; }
  constexpr Color& operator*=(const Color& c) { return *this = {r * c.r, g * c.g, b * c.b}; }
  constexpr Color& operator*=(float s) { return *this = {r * s, g * s, b * s}; }
  friend constexpr Color operator+(const Color& a, const Color& c) {
    return {a.r + c.r, a.g + c.g, a.b + c.b};
  }
  friend constexpr Color operator-(const Color& a, const Color& c) {
    return {a.r - c.r, a.g - c.g, a.b - c.b};
  }
  friend constexpr Color operator*(const Color& a, const Color& c) {
    return {a.r * c.r, a.g * c.g, a.b * c.b};
  }
  friend constexpr Color operator*(const Color& a, float s) { return {a.r * s, a.g * s, a.b * s}; }
  friend constexpr Color operator*(float s, const Color& a) { return a * s; }
  friend constexpr Color operator/(const Color& a, float s) { return {a.r / s, a.g / s, a.b / s}; }
};

constexpr Color gray(float value) { return {value, value, value}; }
constexpr Color to_color(const std::array<double, 3>& c) {
  return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
}
/// Y of CIE 1931 for Rec.709 primaries and D65.
constexpr float luminance(const Color& c) { return 0.2126F * c.r + 0.7152F * c.g + 0.0722F * c.b; }
constexpr float max_component(const Color& c) { return std::max(c.r, std::max(c.g, c.b)); }
constexpr bool is_black(const Color& c) { return c.r == 0 && c.g == 0 && c.b == 0; }
inline bool is_finite(const Color& c) {
  return std::isfinite(c.r) && std::isfinite(c.g) && std::isfinite(c.b);
}

/// Axis-aligned; empty until it is grown.
struct Bounds3 {
  Vec3 low{std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
           std::numeric_limits<float>::infinity()};
  Vec3 high = -low;

  [[nodiscard]] bool empty() const { return !(low.x <= high.x); }
  void grow(const Vec3& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  void grow(const Bounds3& b) {
    if (b.empty()) return;
    grow(b.low);
    grow(b.high);
  }
};

constexpr float pi = 3.14159265358979323846F;
constexpr float inv_pi = 0.31830988618379067154F;
constexpr double pi_d = 3.14159265358979323846;
/// The greatest float below 1.
constexpr float one_minus_epsilon = 0x1.fffffep-1F;

}  // namespace tessera::render
