#include "common/scene/default_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera::scene {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr Bounds nothing{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};

Vec3 times(const Transform& t, const Vec3& p) {
  Vec3 out{};
  for (std::size_t row = 0; row < 3; ++row)
    out[row] =
        t.m[row * 4] * p[0] + t.m[row * 4 + 1] * p[1] + t.m[row * 4 + 2] * p[2] + t.m[row * 4 + 3];
  return out;
}

void grow(Bounds& bounds, const Vec3& p) {
  for (std::size_t i = 0; i < 3; ++i) {
    bounds.low[i] = std::min(bounds.low[i], p[i]);
    bounds.high[i] = std::max(bounds.high[i], p[i]);
  }
}

std::array<Vec3, 8> corners_of(const Bounds& box) {
  std::array<Vec3, 8> out{};
  for (std::size_t corner = 0; corner < 8; ++corner)
    for (std::size_t axis = 0; axis < 3; ++axis)
      out[corner][axis] = (corner >> axis & 1) != 0 ? box.high[axis] : box.low[axis];
  return out;
}

/// Calls `see` with the corners that hold a shape, moved by `t`; with every vertex of a mesh.
template <class See>
void visit(const Bounds& box, const Transform& t, const See& see) {
  if (box.empty()) return;
  for (const Vec3& corner : corners_of(box)) see(times(t, corner));
}
template <class See>
void visit(const Quad& quad, const Transform& t, const See& see) {
  for (int u = 0; u < 2; ++u)
    for (int v = 0; v < 2; ++v) {
      Vec3 p = quad.corner;
      for (std::size_t i = 0; i < 3; ++i) p[i] += u * quad.edge_u[i] + v * quad.edge_v[i];
      see(times(t, p));
    }
}
template <class See>
void visit(const Disk& disk, const Transform& t, const See& see) {
  visit(square_around(disk), t, see);
}
template <class See>
void visit(const Sphere& sphere, const Transform& t, const See& see) {
  Bounds box{sphere.center, sphere.center};
  for (std::size_t i = 0; i < 3; ++i) {
    box.low[i] -= sphere.radius;
    box.high[i] += sphere.radius;
  }
  visit(box, t, see);
}
template <class See>
void visit(const Box& box, const Transform& t, const See& see) {
  visit(Bounds{box.low, box.high}, t, see);
}
template <class See>
void visit(const Mesh& mesh, const Transform& t, const See& see) {
  for (const auto& p : mesh.positions) see(times(t, {p[0], p[1], p[2]}));
}
template <class See>
void visit(const std::vector<Shape>& shapes, const See& see) {
  for (const Shape& shape : shapes)
    std::visit([&](const auto& geometry) { visit(geometry, shape.to_world, see); }, shape.geometry);
}
/// Of instances, the corners of their objects' boxes.
template <class See>
void visit(const Scene& scene, const See& see) {
  visit(scene.shapes, see);
  std::vector<Bounds> objects;
  for (const Object& object : scene.objects) {
    objects.push_back(nothing);
    visit(object.shapes, [&](const Vec3& p) { grow(objects.back(), p); });
  }
  for (const Instance& instance : scene.instances)
    visit(objects[instance.object], instance.to_world, see);
}

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vec3 normalized(const Vec3& v) {
  const double size = std::sqrt(dot(v, v));
  return {v[0] / size, v[1] / size, v[2] / size};
}

}  // namespace

Bounds bounds_of(const Scene& scene) {
  Bounds out = nothing;
  visit(scene, [&](const Vec3& p) { grow(out, p); });
  return out;
}

Camera view_of(const Scene& scene, double aspect) {
  constexpr double degrees = 35, margin = 1.12;
  Camera out;
  out.fov_y_degrees = degrees;
  out.least_aspect = aspect;
  const Bounds bounds = bounds_of(scene);
  if (bounds.empty()) return out;
  const Vec3 back = normalized({0.55, 0.35, 1});
  const Vec3 right = normalized(cross({0, 1, 0}, back)), up = cross(back, right);
  const double tan_y = std::tan(degrees / 360 * 3.14159265358979323846), tan_x = tan_y * aspect;
  for (std::size_t i = 0; i < 3; ++i) out.target[i] = 0.5 * (bounds.low[i] + bounds.high[i]);
  // How far back the eye must stand for each of the film's four edges to clear every point. A step
  // to a side takes from one of two edges what it gives the other.
  std::array<double, 4> needed{-infinity, -infinity, -infinity, -infinity};
  visit(scene, [&](const Vec3& point) {
    const Vec3 p{point[0] - out.target[0], point[1] - out.target[1], point[2] - out.target[2]};
    const double x = dot(right, p) / tan_x, y = dot(up, p) / tan_y, z = dot(back, p);
    const std::array<double, 4> of_point{z + x, z - x, z + y, z - y};
    for (std::size_t i = 0; i < 4; ++i) needed[i] = std::max(needed[i], of_point[i]);
  });
  const double aside = 0.5 * tan_x * (needed[0] - needed[1]);
  const double above = 0.5 * tan_y * (needed[2] - needed[3]);
  const double distance =
      margin * std::max({1e-6, 0.5 * (needed[0] + needed[1]), 0.5 * (needed[2] + needed[3])});
  for (std::size_t i = 0; i < 3; ++i) {
    out.target[i] += right[i] * aside + up[i] * above;
    out.eye[i] = out.target[i] + back[i] * distance;
  }
  return out;
}

bool has_light(const Scene& scene) {
  const auto emits = [](const Material& material) {
    if (std::holds_alternative<Emitter>(material.surface)) return true;
    const auto* surface = std::get_if<Principled>(&material.surface);
    return surface != nullptr && !surface->unlit && !surface->emission.texture &&
           surface->emission.factor != Color{0, 0, 0};
  };
  return scene.environment || !scene.lights.empty() ||
         std::any_of(scene.materials.begin(), scene.materials.end(), emits);
}

}  // namespace tessera::scene
