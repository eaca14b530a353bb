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

void grow_by_box(Bounds& bounds, const Bounds& box, const Transform& t) {
  if (box.empty()) return;
  for (const Vec3& corner : corners_of(box)) grow(bounds, times(t, corner));
}

void grow_by(Bounds& bounds, const Quad& quad, const Transform& t) {
  for (int u = 0; u < 2; ++u)
    for (int v = 0; v < 2; ++v) {
      Vec3 p = quad.corner;
      for (std::size_t i = 0; i < 3; ++i) p[i] += u * quad.edge_u[i] + v * quad.edge_v[i];
      grow(bounds, times(t, p));
    }
}
void grow_by(Bounds& bounds, const Sphere& sphere, const Transform& t) {
  Bounds box{sphere.center, sphere.center};
  for (std::size_t i = 0; i < 3; ++i) {
    box.low[i] -= sphere.radius;
    box.high[i] += sphere.radius;
  }
  grow_by_box(bounds, box, t);
}
void grow_by(Bounds& bounds, const Box& box, const Transform& t) {
  grow_by_box(bounds, {box.low, box.high}, t);
}
void grow_by(Bounds& bounds, const Mesh& mesh, const Transform& t) {
  for (const auto& p : mesh.positions) grow(bounds, times(t, {p[0], p[1], p[2]}));
}

Bounds bounds_of(const std::vector<Shape>& shapes) {
  Bounds out = nothing;
  for (const Shape& shape : shapes)
    std::visit([&](const auto& geometry) { grow_by(out, geometry, shape.to_world); },
               shape.geometry);
  return out;
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
  Bounds out = bounds_of(scene.shapes);
  std::vector<Bounds> objects;
  for (const Object& object : scene.objects) objects.push_back(bounds_of(object.shapes));
  for (const Instance& instance : scene.instances)
    grow_by_box(out, objects[instance.object], instance.to_world);
  return out;
}

Camera view_of(const Bounds& bounds, double aspect) {
  constexpr double degrees = 35, margin = 1.08;
  Camera out;
  out.fov_y_degrees = degrees;
  if (bounds.empty()) return out;
  const Vec3 back = normalized({0.55, 0.35, 1});
  const Vec3 right = normalized(cross({0, 1, 0}, back)), up = cross(back, right);
  const double tan_y = std::tan(degrees / 360 * 3.14159265358979323846), tan_x = tan_y * aspect;
  for (std::size_t i = 0; i < 3; ++i) out.target[i] = 0.5 * (bounds.low[i] + bounds.high[i]);
  double distance = 1e-6;
  for (const Vec3& corner : corners_of(bounds)) {
    const Vec3 p{corner[0] - out.target[0], corner[1] - out.target[1], corner[2] - out.target[2]};
    distance = std::max({distance, std::abs(dot(right, p)) / tan_x + dot(back, p),
                         std::abs(dot(up, p)) / tan_y + dot(back, p)});
  }
  for (std::size_t i = 0; i < 3; ++i) out.eye[i] = out.target[i] + back[i] * distance * margin;
  return out;
}

bool has_light(const Scene& scene) {
  const auto emits = [](const Material& material) {
    if (std::holds_alternative<Emitter>(material.surface)) return true;
    const auto* surface = std::get_if<Principled>(&material.surface);
    return surface != nullptr && !surface->unlit && surface->emission.factor != Color{0, 0, 0};
  };
  return scene.environment || !scene.lights.empty() ||
         std::any_of(scene.materials.begin(), scene.materials.end(), emits);
}

Environment studio_environment() { return {.radiance = {0.8, 0.8, 0.8}}; }

}  // namespace tessera::scene
