#include "worker/render/light_point.hpp"

#include <algorithm>

#include "worker/render/interaction.hpp"

namespace tessera::render {
namespace {

Vec3d corner(const Placement& placement, const accel::Point& p) {
  return to_double(placement.point_to_world({p[0], p[1], p[2]}));
}

/// `point` as its share of the edges to `b` and `c`, in their plane.
struct Shares {
  double u = 0, v = 0;

  Shares(const Vec3d& point, const Vec3d& b, const Vec3d& c) {
    const double bb = length_squared(b), bc = dot(b, c), cc = length_squared(c);
    const double determinant = bb * cc - bc * bc;
    if (!(determinant > 0)) return;
    u = std::clamp((cc * dot(point, b) - bc * dot(point, c)) / determinant, 0.0, 1.0);
    v = std::clamp((bb * dot(point, c) - bc * dot(point, b)) / determinant, 0.0, 1.0);
  }
};

/// Where on its face a point of the world lies, as a ray that hits it would say.
void locate(const Geometry& geometry, const Placement& placement, const Vec3d& point,
            accel::Hit& hit) {
  const auto at = [&](std::uint32_t vertex) {
    return corner(placement, geometry.positions[vertex]);
  };
  if (geometry.kind == GeometryKind::spheres) {
    const Vec3d out = point - corner(placement, geometry.spheres[hit.primitive].center);
    // A sphere that emits stands under a rotation and a scale alike in all directions, so the way
    // back is the transpose.
    const std::array<float, 9>& m = placement.normal_to_world;
    for (std::size_t i = 0; i < 3; ++i) {
      hit.ng[i] = static_cast<float>(double{m[i]} * out.x + double{m[i + 3]} * out.y +
                                     double{m[i + 6]} * out.z);
    }
    return;
  }
  if (geometry.kind == GeometryKind::quads) {
    const accel::Quad& face = geometry.quads[hit.primitive];
    const Vec3d a = at(face[0]);
    const Shares shares(point - a, at(face[1]) - a, at(face[3]) - a);
    hit.u = static_cast<float>(shares.u);
    hit.v = static_cast<float>(shares.v);
    return;
  }
  const accel::Triangle& face = geometry.triangles[hit.primitive];
  const Vec3d a = at(face[0]);
  const Shares shares(point - a, at(face[1]) - a, at(face[2]) - a);
  hit.u = static_cast<float>(shares.u);
  hit.v = static_cast<float>(std::min(shares.v, 1 - shares.u));
}

}  // namespace

Color radiance_at(const Scene& scene, const LightSample& sample, const Ray& ray) {
  const Light& light = scene.lights[sample.light];
  accel::Hit hit;
  hit.instance = light.instance;
  hit.geometry = light.geometry;
  hit.primitive = light.primitive;
  hit.t = sample.distance;
  const Placement& placement = scene.placements[scene.placement_of(hit)];
  const Vec3d point =
      to_double(ray.origin) + to_double(ray.direction) * static_cast<double>(sample.distance);
  locate(scene.geometry_of(hit), placement, point, hit);
  const Interaction at = surface_at(scene, ray, hit);
  return emission(scene.materials[at.material], scene.textures, at.shading);
}

}  // namespace tessera::render
