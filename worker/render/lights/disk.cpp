#include <algorithm>
#include <cmath>

#include "worker/render/lights/plane.hpp"
#include "worker/render/lights/shapes.hpp"
#include "worker/render/lights/spherical_disk.hpp"
#include "worker/render/warp.hpp"

namespace tessera::render {
namespace {

/// Below this solid angle a disk is sampled by area, and so are ellipses.
constexpr double least_angle = 1e-6;
/// By which axes may differ, and the cosine between them, of what rounding in float leaves a
/// circle.
constexpr double tolerance = 4e-6;

/// A disk seen from the lit point.
struct SeenDisk {
  Vec3d center, u, v;
  Plane plane;
  bool circle;

  SeenDisk(const DiskLight& disk, const Vec3& p)
      : center(to_double(disk.center) - to_double(p)),
        u(to_double(disk.axis_u)),
        v(to_double(disk.axis_v)),
        plane(center, u, v),
        circle(disk.circle) {}

  /// False too if all of it is behind the lit surface, which scatters none of its light then.
  [[nodiscard]] bool visible(bool two_sided, const Vec3& surface) const {
    if (!plane.visible(two_sided)) return false;
    const Vec3d n = to_double(surface);
    const double a = dot(u, n), b = dot(v, n);
    return dot(center, n) + std::sqrt(a * a + b * b) > 0 || surface == Vec3{};
  }
  [[nodiscard]] SphericalDisk spherical() const {
    return {center, plane.normal / length(plane.normal), length(u)};
  }
  /// 0: sampled by area.
  [[nodiscard]] double solid_angle() const {
    const double angle = circle ? spherical().solid_angle() : 0;
    return angle >= least_angle ? angle : 0;
  }
  [[nodiscard]] double pdf_by_area(double distance, const Vec3d& wi) const {
    return plane.pdf_by_area(pi_d, distance, wi);
  }
};

}  // namespace

DiskLight::DiskLight(const Vec3& center_, const Vec3& axis_u_, const Vec3& axis_v_)
    : center(center_), axis_u(axis_u_), axis_v(axis_v_) {
  const Vec3d u = to_double(axis_u), v = to_double(axis_v);
  const double uu = length_squared(u), vv = length_squared(v);
  circle = std::abs(dot(u, v)) <= tolerance * uu && std::abs(uu - vv) <= 2 * tolerance * uu;
}

ShapeSample sample_shape(const DiskLight& light, bool two_sided, const LightContext& context,
                         Vec2 uv) {
  const SeenDisk disk(light, context.p);
  if (!disk.visible(two_sided, context.n)) return {};
  if (const double angle = disk.solid_angle(); angle > 0) {
    const auto [wi, distance] = disk.spherical().sample(uv);
    if (!(distance > 0)) return {};
    return {.wi = wi, .distance = distance, .pdf = 1 / angle};
  }
  const Vec2 at = square_to_disk(uv);
  ShapeSample sample = towards(
      disk.center + disk.u * static_cast<double>(at.x) + disk.v * static_cast<double>(at.y), 0);
  sample.pdf = disk.pdf_by_area(sample.distance, sample.wi);
  return sample;
}

double pdf_shape(const DiskLight& light, bool two_sided, const LightContext& context,
                 const LightHit& hit) {
  const SeenDisk disk(light, context.p);
  if (!disk.visible(two_sided, context.n)) return 0;
  const double angle = disk.solid_angle();
  return angle > 0 ? 1 / angle : disk.pdf_by_area(hit.distance, to_double(hit.wi));
}

}  // namespace tessera::render
