#include "worker/scene/emitters.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "worker/render/fastmath.hpp"
#include "worker/scene/affine.hpp"
#include "worker/scene/parallelogram.hpp"

namespace tessera::worker {
namespace {

using render::Vec3;
using render::Vec3d;

/// Of the larger size, along each axis.
Vec3 larger(const Vec3& a, const Vec3& b) {
  return {std::max(std::abs(a.x), std::abs(b.x)), std::max(std::abs(a.y), std::abs(b.y)),
          std::max(std::abs(a.z), std::abs(b.z))};
}

/// The largest coordinates of a face that emits, and of the next where both are one light.
Vec3 extent_of_emitter(const render::Geometry& geometry, std::uint32_t face) {
  Vec3 out;
  const auto grow_by = [&](const auto& corners) {
    for (const std::uint32_t vertex : corners) {
      const accel::Point& p = geometry.positions[vertex];
      out = larger(out, {p[0], p[1], p[2]});
    }
  };
  if (geometry.kind == render::GeometryKind::spheres) {
    const accel::Sphere& sphere = geometry.spheres[face];
    const Vec3 reach{sphere.radius, sphere.radius, sphere.radius};
    return larger({sphere.center[0], sphere.center[1], sphere.center[2]}, {}) + reach;
  }
  if (geometry.kind == render::GeometryKind::quads) {
    grow_by(geometry.quads[face]);
    return out;
  }
  grow_by(geometry.triangles[face]);
  if (face + 1 < geometry.faces() && geometry.emitters[face + 1] == geometry.emitters[face])
    grow_by(geometry.triangles[face + 1]);
  return out;
}

class LightMaker {
 public:
  /// `origin` was subtracted from the group's positions.
  LightMaker(const scene::Transform& to_world, const std::array<double, 3>& origin)
      : to_world_(to_world), origin_(origin), mirrored_(determinant(linear(to_world)) < 0) {}

  [[nodiscard]] render::Light make(const render::Geometry& geometry,
                                   const EmittingFace& emitter) const {
    const std::uint32_t face = emitter.primitive;
    render::Light light;
    const auto at = [&](std::uint32_t vertex) { return point(geometry.positions[vertex]); };
    if (geometry.kind == render::GeometryKind::quads) {
      const accel::Quad& quad = geometry.quads[face];
      const Vec3d corner = at(quad[0]);
      Vec3d u = at(quad[1]) - corner, v = at(quad[3]) - corner;
      if (mirrored_) std::swap(u, v);
      if (geometry.round) {
        light.shape = render::DiskLight{render::to_float(corner + (u + v) * 0.5),
                                        render::to_float(u * 0.5), render::to_float(v * 0.5)};
      } else {
        light.shape =
            render::QuadLight{render::to_float(corner), render::to_float(u), render::to_float(v)};
      }
    } else if (emitter.with_next) {
      const Parallelogram whole = parallelogram(geometry, face, origin_).value();
      const Vec3d corner = at(whole.corner);
      Vec3d u = at(whole.end_u) - corner, v = at(whole.end_v) - corner;
      light.uneven = static_cast<float>(render::length(at(whole.across) - (corner + u + v)));
      if (mirrored_) std::swap(u, v);
      light.shape =
          render::QuadLight{render::to_float(corner), render::to_float(u), render::to_float(v)};
    } else if (geometry.kind == render::GeometryKind::triangles) {
      const accel::Triangle& triangle = geometry.triangles[face];
      Vec3d b = at(triangle[1]), c = at(triangle[2]);
      if (mirrored_) std::swap(b, c);
      light.shape = render::TriangleLight{render::to_float(at(triangle[0])), render::to_float(b),
                                          render::to_float(c)};
    } else {
      const accel::Sphere& sphere = geometry.spheres[face];
      const auto scale = uniform_scale(to_world_);
      if (!scale) {
        throw Error(ErrorKind::bad_input,
                    "a sphere that emits is under a transform that makes it an ellipsoid; expected "
                    "one that scales all directions alike");
      }
      light.shape = render::SphereLight{render::to_float(point(sphere.center)),
                                        static_cast<float>(sphere.radius * *scale)};
    }
    return light;
  }

 private:
  [[nodiscard]] Vec3d point(const accel::Point& p) const {
    return times_point(to_world_, {p[0], p[1], p[2]});
  }

  const scene::Transform& to_world_;
  const std::array<double, 3>& origin_;
  bool mirrored_;
};

}  // namespace

std::uint32_t add_lights(const MergedGroup& group,
                         std::span<const render::CompiledMaterial> materials,
                         const scene::Transform& to_world, std::uint32_t instance,
                         std::vector<render::Light>& lights, std::size_t most) {
  if (lights.size() + group.emitters.size() > most) return render::no_id;
  const auto first = static_cast<std::uint32_t>(lights.size());
  const LightMaker maker(to_world, group.origin);
  for (const EmittingFace& emitter : group.emitters) {
    const render::Geometry& geometry = group.group.geometries[emitter.geometry];
    const render::CompiledMaterial& material = materials[geometry.materials[emitter.primitive]];
    render::Light light = maker.make(geometry, emitter);
    light.radiance = emitter.radiance;
    light.two_sided = material.two_sided;
    light.varies = material.radiance_varies;
    light.group = material.light_group;
    light.instance = instance;
    light.geometry = emitter.geometry;
    light.primitive = emitter.primitive;
    lights.push_back(light);
  }
  return first;
}

render::Light punctual_light(const scene::PunctualLight& light, const std::array<double, 3>& origin,
                             const render::Bounds3& bounds) {
  const auto at = [&](const scene::Vec3& p) {
    return render::to_float(render::to_vec3d(p) - render::to_vec3d(origin));
  };
  const auto unit = [](const scene::Vec3& v) {
    return render::to_float(render::normalize(render::to_vec3d(v)));
  };
  render::Light out;
  if (const auto* point = std::get_if<scene::PointLight>(&light.shape)) {
    out.shape = render::PointLight{at(point->position)};
    out.radiance = render::to_color(point->intensity);
  } else if (const auto* spot = std::get_if<scene::SpotLight>(&light.shape)) {
    constexpr double radians = render::pi_d / 180;
    out.shape = render::SpotLight{
        .position = at(spot->position),
        .axis = unit(spot->direction),
        .cos_inner = static_cast<float>(render::fast::sincos(spot->inner_degrees * radians).second),
        .cos_outer =
            static_cast<float>(render::fast::sincos(spot->outer_degrees * radians).second)};
    out.radiance = render::to_color(spot->intensity);
  } else {
    const auto& far = std::get<scene::DirectionalLight>(light.shape);
    const float radius =
        bounds.empty() ? 1 : std::max(0.5F * render::length(bounds.high - bounds.low), 1e-30F);
    out.radiance = render::to_color(far.irradiance);
    if (far.angle_degrees > 0) {
      const double half_sine = render::fast::sincos(far.angle_degrees * render::pi_d / 720).first;
      const render::SunLight sun{unit(far.direction), 2 * half_sine * half_sine, radius};
      out.shape = sun;
      out.radiance *= static_cast<float>(1 / sun.projected());
    } else {
      out.shape = render::DirectionalLight{unit(far.direction), radius};
    }
  }
  return out;
}

float rounding_error(const render::Light& light, const render::Scene& scene) {
  const render::Bounds3 bounds = render::bounds(light);
  if (bounds.empty()) return 0;
  Vec3 most = larger(bounds.low, bounds.high);
  if (light.instance != render::no_id) {
    const render::Placement& placement =
        scene.placements[light.instance - scene.world_geometries + 1];
    const render::Group& group = scene.groups[placement.group];
    const Vec3 own = extent_of_emitter(group.geometries[light.geometry], light.primitive);
    most = larger(most, placement.extent_to_world(own));
  }
  const float size = std::max({most.x, most.y, most.z});
  return std::max(size * 0x1p-20F, size * 0x1p-21F + light.uneven);
}

}  // namespace tessera::worker
