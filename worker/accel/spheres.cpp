#include "worker/accel/spheres.hpp"

#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "worker/accel/accel.hpp"

namespace tessera::accel {
namespace {

/// The nearest t in [near, far], or −1. In double, so that a ray that starts a few float steps
/// outside the sphere misses it and the nearer root is never lost to cancellation (Haines et al.,
/// Ray Tracing Gems, chapter 7).
double nearest_root(const Sphere& sphere, const RTCRay& ray) {
  const double dx = ray.dir_x, dy = ray.dir_y, dz = ray.dir_z;
  const double fx = static_cast<double>(ray.org_x) - sphere.center[0];
  const double fy = static_cast<double>(ray.org_y) - sphere.center[1];
  const double fz = static_cast<double>(ray.org_z) - sphere.center[2];
  const double r = sphere.radius;
  const double a = dx * dx + dy * dy + dz * dz;
  const double b = -(fx * dx + fy * dy + fz * dz);
  // The discriminant by the distance of the line from the centre, not by b² − ac.
  const double s = b / a;
  const double px = fx + s * dx, py = fy + s * dy, pz = fz + s * dz;
  const double discriminant = r * r - (px * px + py * py + pz * pz);
  if (!(discriminant >= 0)) return -1;
  const double q = b + (b >= 0 ? 1.0 : -1.0) * std::sqrt(a * discriminant);
  const double c = fx * fx + fy * fy + fz * fz - r * r;
  double first = q == 0 ? 0 : c / q;
  double second = q / a;
  if (first > second) std::swap(first, second);
  const double near = ray.tnear, far = ray.tfar;
  if (first >= near && first <= far) return first;
  if (second >= near && second <= far) return second;
  return -1;
}

}  // namespace

void sphere_bounds(const RTCBoundsFunctionArguments* args) {
  const Sphere& sphere = static_cast<const Sphere*>(args->geometryUserPtr)[args->primID];
  const auto below = [](float c, float r) {
    return std::nextafter(c - r, -std::numeric_limits<float>::infinity());
  };
  const auto above = [](float c, float r) {
    return std::nextafter(c + r, std::numeric_limits<float>::infinity());
  };
  RTCBounds& out = *args->bounds_o;
  out.lower_x = below(sphere.center[0], sphere.radius);
  out.lower_y = below(sphere.center[1], sphere.radius);
  out.lower_z = below(sphere.center[2], sphere.radius);
  out.upper_x = above(sphere.center[0], sphere.radius);
  out.upper_y = above(sphere.center[1], sphere.radius);
  out.upper_z = above(sphere.center[2], sphere.radius);
}

void sphere_intersect(const RTCIntersectFunctionNArguments* args) {
  assert(args->N == 1);
  if (args->valid[0] == 0) return;
  auto& both = *reinterpret_cast<RTCRayHit*>(args->rayhit);
  const Sphere& sphere = static_cast<const Sphere*>(args->geometryUserPtr)[args->primID];
  const double t = nearest_root(sphere, both.ray);
  if (t < 0) return;
  both.ray.tfar = static_cast<float>(t);
  both.hit.Ng_x = static_cast<float>(both.ray.org_x + t * both.ray.dir_x - sphere.center[0]);
  both.hit.Ng_y = static_cast<float>(both.ray.org_y + t * both.ray.dir_y - sphere.center[1]);
  both.hit.Ng_z = static_cast<float>(both.ray.org_z + t * both.ray.dir_z - sphere.center[2]);
  both.hit.u = 0;
  both.hit.v = 0;
  both.hit.primID = args->primID;
  both.hit.geomID = args->geomID;
  embree::set_instance(both.hit, *args->context);
}

void sphere_occluded(const RTCOccludedFunctionNArguments* args) {
  assert(args->N == 1);
  if (args->valid[0] == 0) return;
  auto& ray = *reinterpret_cast<RTCRay*>(args->ray);
  const Sphere& sphere = static_cast<const Sphere*>(args->geometryUserPtr)[args->primID];
  if (nearest_root(sphere, ray) >= 0) ray.tfar = -std::numeric_limits<float>::infinity();
}

}  // namespace tessera::accel
