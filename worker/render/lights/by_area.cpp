#include "worker/render/lights/by_area.hpp"

#include <cmath>

#include "worker/render/lights/environment_map.hpp"
#include "worker/render/warp.hpp"

namespace tessera::render {
namespace {

/// A point of a light relative to the one that is lit, its normal (the outer or emitting side), and
/// the light's area.
struct AreaPoint {
  Vec3d offset, normal;
  double area = 0;
};

AreaPoint point_on(const QuadLight& quad, const Vec3d& from, Vec2 u) {
  const Vec3d edge_u = to_double(quad.edge_u), edge_v = to_double(quad.edge_v);
  const Vec3d normal = cross(edge_u, edge_v);
  const double area = length(normal);
  return {to_double(quad.corner) - from + edge_u * static_cast<double>(u.x) +
              edge_v * static_cast<double>(u.y),
          normal / area, area};
}

AreaPoint point_on(const DiskLight& disk, const Vec3d& from, Vec2 u) {
  const Vec3d axis_u = to_double(disk.axis_u), axis_v = to_double(disk.axis_v);
  const Vec3d normal = cross(axis_u, axis_v);
  const double box = length(normal);
  const Vec2 at = square_to_disk(u);
  return {to_double(disk.center) - from + axis_u * static_cast<double>(at.x) +
              axis_v * static_cast<double>(at.y),
          normal / box, pi_d * box};
}

AreaPoint point_on(const TriangleLight& triangle, const Vec3d& from, Vec2 u) {
  const Vec3d a = to_double(triangle.a);
  const Vec3d ab = to_double(triangle.b) - a, ac = to_double(triangle.c) - a;
  const Vec3d normal = cross(ab, ac);
  const double twice = length(normal);
  const Vec2 b = square_to_triangle(u);
  return {a - from + ab * static_cast<double>(b.x) + ac * static_cast<double>(b.y), normal / twice,
          0.5 * twice};
}

AreaPoint point_on(const SphereLight& sphere, const Vec3d& from, Vec2 u) {
  const Vec3d normal = normalize(to_double(square_to_sphere(u)));
  const double radius = static_cast<double>(sphere.radius);
  return {to_double(sphere.center) - from + normal * radius, normal, 4 * pi_d * radius * radius};
}

template <class Shape>
LightSample towards(const Light& light, const Shape& shape, const LightContext& context, Vec2 u) {
  const AreaPoint point = point_on(shape, to_double(context.p), u);
  const double square = length_squared(point.offset);
  if (!(square > 0) || !(point.area > 0)) return {};
  const double distance = std::sqrt(square);
  const Vec3d wi = point.offset / distance;
  const double facing = -dot(wi, point.normal);
  const double cosine = light.two_sided ? std::abs(facing) : facing;
  if (!(cosine > 0)) return {};
  const auto pdf = static_cast<float>(square / (cosine * point.area));
  if (!(pdf > 0) || !std::isfinite(pdf)) return {};
  return {.wi = to_float(wi),
          .distance = static_cast<float>(distance),
          .radiance = light.radiance,
          .pdf = pdf,
          .instance = light.instance,
          .primitive = light.primitive};
}

}  // namespace

LightSample sample_by_area(const Light& light, const LightContext& context, Vec2 u) {
  if (const auto* quad = std::get_if<QuadLight>(&light.shape)) {
    return towards(light, *quad, context, u);
  }
  if (const auto* disk = std::get_if<DiskLight>(&light.shape)) {
    return towards(light, *disk, context, u);
  }
  if (const auto* triangle = std::get_if<TriangleLight>(&light.shape)) {
    return towards(light, *triangle, context, u);
  }
  if (const auto* sphere = std::get_if<SphereLight>(&light.shape)) {
    return towards(light, *sphere, context, u);
  }
  const auto* environment = std::get_if<EnvironmentLight>(&light.shape);
  if (environment != nullptr && environment->map != nullptr) {
    const EnvironmentMap::Drawn drawn = environment->map->sample_all(u);
    return {.wi = to_float(drawn.direction),
            .radiance = light.radiance * drawn.radiance,
            .pdf = static_cast<float>(drawn.pdf)};
  }
  return sample(light, context, u);
}

}  // namespace tessera::render
