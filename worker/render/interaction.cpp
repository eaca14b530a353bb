#include "worker/render/interaction.hpp"

#include <cmath>

#include "worker/render/bsdf/normal_map.hpp"
#include "worker/render/octahedral.hpp"

namespace tessera::render {
namespace {

constexpr float rounding = 0x1p-24F;
/// How many roundings stand between the vertices and a point at which the intersector surely finds
/// itself on the outside: position, offset, transform, and Embree's plane distance have at most
/// about 16 each counted generously.
constexpr float roundings = 16;

Vec3 vec(const accel::Point& p) { return {p[0], p[1], p[2]}; }
Vec3 absolute(const Vec3& v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }
Vec3 larger(const Vec3& a, const Vec3& b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

float max_of(const Vec3& v) { return std::max(v.x, std::max(v.y, v.z)); }

/// A point in the space of its group, its normals, and the size of the coordinates it came from.
struct Local {
  Vec3 p;
  Vec3 normal;          ///< of any length
  Vec3 shading_normal;  ///< of any length
  Vec3 extent;
  bool flat = true;
};

/// The direction of edge_u × edge_v, of unit length. In double: the squares of a product of two
/// lengths leave float's range long before the lengths do.
Vec3 normal_of(const Vec3& edge_u, const Vec3& edge_v) {
  return to_float(normalize(cross(to_double(edge_u), to_double(edge_v))));
}

Local on_triangle(const Geometry& geometry, const accel::Hit& hit) {
  const accel::Triangle& face = geometry.triangles[hit.primitive];
  const Vec3 a = vec(geometry.positions[face[0]]);
  const Vec3 b = vec(geometry.positions[face[1]]);
  const Vec3 c = vec(geometry.positions[face[2]]);
  const float w = 1 - hit.u - hit.v;
  Local local;
  local.p = a * w + b * hit.u + c * hit.v;
  local.normal = normal_of(b - a, c - a);
  local.extent = larger(absolute(a), larger(absolute(b), absolute(c)));
  if (!geometry.normals.empty()) {
    local.flat = false;
    local.shading_normal = decode_octahedral(geometry.normals[face[0]]) * w +
                           decode_octahedral(geometry.normals[face[1]]) * hit.u +
                           decode_octahedral(geometry.normals[face[2]]) * hit.v;
  }
  return local;
}

Local on_quad(const Geometry& geometry, const accel::Hit& hit) {
  const accel::Quad& face = geometry.quads[hit.primitive];
  const Vec3 a = vec(geometry.positions[face[0]]);
  const Vec3 b = vec(geometry.positions[face[1]]);
  const Vec3 c = vec(geometry.positions[face[2]]);
  const Vec3 d = vec(geometry.positions[face[3]]);
  Local local;
  // A parallelogram in all but the last bit; Embree sees the triangles abd and cdb.
  local.p = hit.u + hit.v <= 1 ? a * (1 - hit.u - hit.v) + b * hit.u + d * hit.v
                               : c * (hit.u + hit.v - 1) + d * (1 - hit.u) + b * (1 - hit.v);
  local.normal = normal_of(b - a, d - a);
  local.extent = larger(larger(absolute(a), absolute(b)), larger(absolute(c), absolute(d)));
  return local;
}

Local on_sphere(const Geometry& geometry, const accel::Hit& hit) {
  const accel::Sphere& sphere = geometry.spheres[hit.primitive];
  Local local;
  local.normal = normalize(vec(hit.ng));
  local.p = vec(sphere.center) + local.normal * sphere.radius;
  local.extent = absolute(vec(sphere.center)) + Vec3{sphere.radius, sphere.radius, sphere.radius};
  return local;
}

Vec3 normal_to_world(const Placement& placement, const Vec3& n) {
  const std::array<float, 9>& m = placement.normal_to_world;
  return {m[0] * n.x + m[1] * n.y + m[2] * n.z, m[3] * n.x + m[4] * n.y + m[5] * n.z,
          m[6] * n.x + m[7] * n.y + m[8] * n.z};
}

/// From the group's space to the world.
void place(const Placement& placement, Local& local) {
  local.p = placement.point_to_world(local.p);
  local.extent = placement.extent_to_world(local.extent);
  local.normal = normal_to_world(placement, local.normal);
  local.shading_normal = normal_to_world(placement, local.shading_normal);
}

Local local_point(const Geometry& geometry, const accel::Hit& hit) {
  switch (geometry.kind) {
    case GeometryKind::triangles:
      return on_triangle(geometry, hit);
    case GeometryKind::quads:
      return on_quad(geometry, hit);
    case GeometryKind::spheres:
      break;
  }
  return on_sphere(geometry, hit);
}

}  // namespace

Interaction surface_at(const Scene& scene, const Ray& ray, const accel::Hit& hit) {
  Interaction at;
  at.placement = scene.placement_of(hit);
  const Placement& placement = scene.placements[at.placement];
  const Geometry& geometry = scene.groups[placement.group].geometries[hit.geometry];
  Local local = local_point(geometry, hit);
  if (placement.moved) place(placement, local);

  at.p = local.p;
  at.t = hit.t;
  at.u = hit.u;
  at.v = hit.v;
  at.geometry = hit.geometry;
  at.primitive = hit.primitive;
  at.instance = hit.instance;
  at.material = geometry.materials[hit.primitive];
  if (!geometry.emitters.empty()) {
    const std::uint32_t emitter = geometry.emitters[hit.primitive];
    if (emitter != no_id && placement.first_light != no_id)
      at.light = placement.first_light + emitter;
  }
  ShadingPoint& point = at.shading;
  point.wo = -ray.direction;
  point.normal = normalize(local.normal);
  point.footprint = ray.cone_width + ray.cone_spread * hit.t;
  Vec3 n = point.normal;
  if (!local.flat) {
    n = normalize(local.shading_normal);
    if (dot(n, point.normal) < 0) n = -n;
    if (!(length_squared(n) > 0)) n = point.normal;
    n = keep_mirrored_outside(n, point.normal, point.wo);
    point.rounded = true;
  }
  point.shading = Frame(n);
  if (geometry.details != 0) {
    point.detail = detail_at(geometry, placement, hit,
                             {.direction = ray.direction,
                              .normal = point.normal,
                              .shading = n,
                              .width = point.footprint});
  }
  const float reach = max_of(absolute(at.p)), size = max_of(local.extent);
  // Never 0, not even at the origin of a face whose plane goes through it: a ray that starts in the
  // very plane meets it.
  at.error = roundings * rounding *
             (dot(absolute(point.normal), local.extent) + std::max(reach, rounding * size));
  return at;
}

bool leave_rounded(const Scene& scene, const Interaction& at, Ray& ray) {
  const Placement& placement = scene.placements[at.placement];
  const Geometry& geometry = scene.groups[placement.group].geometries[at.geometry];
  const accel::Triangle& face = geometry.triangles[at.primitive];
  const Vec3& normal = at.shading.normal;
  const Vec3 outward = dot(at.shading.wo, normal) < 0 ? -normal : normal;
  const std::array<float, 3> weights{1 - at.u - at.v, at.u, at.v};
  std::array<Vec3, 3> ways, normals;  // from the corners to the hit
  Vec3 mean;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 corner = vec(geometry.positions[face[i]]);
    const Vec3 n = decode_octahedral(geometry.normals[face[i]]);
    ways[i] = at.p - (placement.moved ? placement.point_to_world(corner) : corner);
    normals[i] = placement.moved ? normalize(normal_to_world(placement, n)) : n;
    if (dot(normals[i], outward) < 0) normals[i] = -normals[i];
    mean += normals[i] * weights[i];
  }
  mean = normalize(mean);
  Vec3 over;
  float size = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const float below = dot(ways[i], mean - normals[i]);
    if (below > 0) over += normals[i] * (below * weights[i]);
    size = std::max(size, max_of(absolute(ways[i])));
  }
  if (!(dot(over, outward) > at.error + roundings * rounding * size)) return false;
  const Vec3 end = ray.origin + ray.direction * ray.t_max;
  ray.origin = at.p + over + outward * at.error;
  if (std::isinf(ray.t_max)) return true;
  ray.t_max = length(end - ray.origin);
  ray.direction = (end - ray.origin) / ray.t_max;
  return ray.t_max > 0;
}

Color transmittance_through(const Scene& scene, Ray ray) {
  float passed = 1;
  for (int surfaces = 0; surfaces < passes_most; ++surfaces) {
    const accel::Hit hit = scene.intersect(ray, ray_mask::shadow);
    if (!hit.any()) return gray(passed);
    const Interaction at = surface_at(scene, ray, hit);
    passed *= passing_share(scene, at);
    if (!(passed > 0)) return {};
    ray.t_min = at.behind(ray);
    if (!(ray.t_min < ray.t_max)) return gray(passed);
  }
  return {};
}

}  // namespace tessera::render
