#include "worker/render/lights/light.hpp"

#include <array>
#include <cassert>
#include <cmath>

#include "worker/render/lights/environment_map.hpp"
#include "worker/render/lights/shapes.hpp"

namespace tessera::render {

namespace {

// In double: the square of a product of two lengths leaves float's range.
Vec3d normal_of(const QuadLight& quad) {
  return cross(to_double(quad.edge_u), to_double(quad.edge_v));
}
Vec3d normal_of(const DiskLight& disk) {
  return cross(to_double(disk.axis_u), to_double(disk.axis_v));
}
Vec3d normal_of(const TriangleLight& t) {
  const Vec3d a = to_double(t.a);
  return cross(to_double(t.b) - a, to_double(t.c) - a);
}

/// True if p, seen along -wi from the light, is on the side to which it emits.
bool faces(const QuadLight& quad, const LightContext&, const Vec3& wi) {
  return dot(normal_of(quad), to_double(wi)) < 0;
}
bool faces(const DiskLight& disk, const LightContext&, const Vec3& wi) {
  return dot(normal_of(disk), to_double(wi)) < 0;
}
bool faces(const TriangleLight& triangle, const LightContext&, const Vec3& wi) {
  return dot(normal_of(triangle), to_double(wi)) < 0;
}
bool faces(const SphereLight& sphere, const LightContext& context, const Vec3&) {
  const Vec3d d = to_double(context.p) - to_double(sphere.center);
  return length_squared(d) > static_cast<double>(sphere.radius) * sphere.radius;
}
bool faces(const EnvironmentLight&, const LightContext&, const Vec3&) { return true; }
bool faces(const SunLight& sun, const LightContext&, const Vec3& wi) { return sun.holds(wi); }
template <class Delta>
bool faces(const Delta&, const LightContext&, const Vec3&) {
  static_assert(is_delta<Delta>);
  return false;
}

Bounds3 bounds_of(const QuadLight& quad) {
  Bounds3 box;
  box.grow(quad.corner);
  box.grow(quad.corner + quad.edge_u);
  box.grow(quad.corner + quad.edge_v);
  box.grow(quad.corner + quad.edge_u + quad.edge_v);
  return box;
}
Bounds3 bounds_of(const DiskLight& disk) {
  const Vec3d u = to_double(disk.axis_u), v = to_double(disk.axis_v);
  const auto reach = [](double a, double b) { return std::sqrt(a * a + b * b); };
  const Vec3 half = to_float({reach(u.x, v.x), reach(u.y, v.y), reach(u.z, v.z)});
  return {disk.center - half, disk.center + half};
}
Bounds3 bounds_of(const TriangleLight& triangle) {
  Bounds3 box;
  box.grow(triangle.a);
  box.grow(triangle.b);
  box.grow(triangle.c);
  return box;
}
Bounds3 bounds_of(const SphereLight& sphere) {
  const Vec3 r = {sphere.radius, sphere.radius, sphere.radius};
  return {sphere.center - r, sphere.center + r};
}
Bounds3 bounds_of(const EnvironmentLight&) { return {}; }
Bounds3 bounds_of(const PointLight& point) { return {point.position, point.position}; }
Bounds3 bounds_of(const SpotLight& spot) { return {spot.position, spot.position}; }
Bounds3 bounds_of(const DirectionalLight&) { return {}; }
Bounds3 bounds_of(const SunLight&) { return {}; }

/// What the power of radiance 1 is on one side: ∫∫ cos θ dω dA, in m²·sr.
double etendue_of(const QuadLight& quad) { return pi_d * length(normal_of(quad)); }
double etendue_of(const DiskLight& disk) { return pi_d * pi_d * length(normal_of(disk)); }
double etendue_of(const TriangleLight& t) { return 0.5 * pi_d * length(normal_of(t)); }
double etendue_of(const SphereLight& sphere) {
  return 4 * pi_d * pi_d * static_cast<double>(sphere.radius) * sphere.radius;
}
double etendue_of(const EnvironmentLight& environment) {
  return 4 * pi_d * pi_d * static_cast<double>(environment.radius) * environment.radius;
}

double etendue_of(const PointLight&) { return 4 * pi_d; }
/// The integral of its falloff over directions.
double etendue_of(const SpotLight& spot) {
  const auto inner = static_cast<double>(spot.cos_inner),
             outer = static_cast<double>(spot.cos_outer);
  return 2 * pi_d * ((1 - inner) + (inner - outer) / 3);
}
double etendue_of(const DirectionalLight& light) {
  return pi_d * static_cast<double>(light.radius) * light.radius;
}

double etendue_of(const SunLight& sun) {
  return sun.projected() * pi_d * static_cast<double>(sun.radius) * sun.radius;
}

/// The area that is seen from where most of it is, m²; 1 where radiance stands for intensity.
double seen_area_of(const QuadLight& quad) { return etendue_of(quad) / pi_d; }
double seen_area_of(const DiskLight& disk) { return etendue_of(disk) / pi_d; }
double seen_area_of(const TriangleLight& triangle) { return etendue_of(triangle) / pi_d; }
double seen_area_of(const SphereLight& sphere) {
  return pi_d * static_cast<double>(sphere.radius) * sphere.radius;
}
double seen_area_of(const PointLight&) { return 1; }
double seen_area_of(const SpotLight&) { return 1; }
double seen_area_of(const EnvironmentLight&) { return 0; }
double seen_area_of(const DirectionalLight&) { return 0; }
double seen_area_of(const SunLight&) { return 0; }

/// The mean over the light, in the light's own unit.
Color mean_radiance(const Light& light) {
  const auto* environment = std::get_if<EnvironmentLight>(&light.shape);
  if (environment == nullptr || environment->map == nullptr) return light.radiance;
  return light.radiance * environment->map->mean();
}

/// What the environment sends from `wi`, as a share of its light's radiance.
Color share_along(const Light& light, const Vec3d& wi) {
  const auto* environment = std::get_if<EnvironmentLight>(&light.shape);
  if (environment == nullptr || environment->map == nullptr) return gray(1);
  return environment->map->radiance(wi);
}

template <class Flat>
EmissionCone flat_cone(const Flat& flat, bool two_sided) {
  return {.axis = to_float(normalize(normal_of(flat))), .cos_theta_o = two_sided ? -1.0F : 1.0F};
}
EmissionCone cone_of(const QuadLight& quad, bool two_sided) { return flat_cone(quad, two_sided); }
EmissionCone cone_of(const DiskLight& disk, bool two_sided) { return flat_cone(disk, two_sided); }
EmissionCone cone_of(const TriangleLight& t, bool two_sided) { return flat_cone(t, two_sided); }
EmissionCone cone_of(const SphereLight&, bool) { return {}; }
EmissionCone cone_of(const EnvironmentLight&, bool) { return {}; }
EmissionCone cone_of(const PointLight&, bool) { return {}; }
EmissionCone cone_of(const SpotLight& spot, bool) {
  return {.axis = spot.axis, .cos_theta_o = 1, .cos_theta_e = spot.cos_outer};
}
EmissionCone cone_of(const DirectionalLight& light, bool) {
  return {.axis = light.direction, .cos_theta_o = 1, .cos_theta_e = 1};
}
EmissionCone cone_of(const SunLight& sun, bool) {
  return {.axis = sun.direction, .cos_theta_o = 1, .cos_theta_e = static_cast<float>(1 - sun.cap)};
}

LightSample light_sample(const Light& light, const ShapeSample& drawn, bool delta) {
  const auto pdf = static_cast<float>(drawn.pdf);
  // Beyond float's range the light is a point, and this way to draw it has come to its end.
  if (!(pdf > 0) || !std::isfinite(pdf)) return {};
  return {.wi = to_float(drawn.wi),
          .distance = static_cast<float>(drawn.distance),
          .radiance = light.radiance * drawn.share,
          .pdf = pdf,
          .delta = delta,
          .instance = light.instance,
          .primitive = light.primitive};
}

/// Rectangles that wait until there are enough of them to go side by side.
class WaitingRectangles {
 public:
  explicit WaitingRectangles(std::span<LightSample> found) : found_(found) {}

  void add(std::size_t index, const Light& light, const QuadLight& quad,
           const LightContext& context, Vec2 u) {
    indices_[count_] = index;
    lights_[count_] = &light;
    asked_[count_++] = {&quad, light.two_sided, &context, u};
    if (count_ == asked_.size()) answer();
  }
  void answer() {
    std::array<ShapeSample, WideDouble::lanes> drawn;
    sample_rectangles({asked_.data(), count_}, drawn);
    for (std::size_t i = 0; i < count_; ++i)
      found_[indices_[i]] = light_sample(*lights_[i], drawn[i], false);
    count_ = 0;
  }

 private:
  std::span<LightSample> found_;
  std::size_t count_ = 0;
  std::array<std::size_t, WideDouble::lanes> indices_{};
  std::array<const Light*, WideDouble::lanes> lights_{};
  std::array<RectangleRequest, WideDouble::lanes> asked_;
};

}  // namespace

LightSample sample(const Light& light, const LightContext& context, Vec2 u) {
  return std::visit(
      [&](const auto& shape) {
        return light_sample(light, sample_shape(shape, light.two_sided, context, u),
                            is_delta<std::remove_cvref_t<decltype(shape)>>);
      },
      light.shape);
}

void sample(std::span<const LightDraw> asked, std::span<LightSample> found) {
  assert(asked.size() <= found.size());
  WaitingRectangles waiting(found);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const auto& [light, context, u] = asked[i];
    if (light == nullptr) {
      found[i] = {};
      continue;
    }
    const auto* quad = std::get_if<QuadLight>(&light->shape);
    if (quad != nullptr && quad->rectangle)
      waiting.add(i, *light, *quad, *context, u);
    else
      found[i] = sample(*light, *context, u);
  }
  waiting.answer();
}

float pdf(const Light& light, const LightContext& context, const LightHit& hit) {
  const auto density = static_cast<float>(std::visit(
      [&](const auto& shape) {
        if constexpr (is_delta<std::remove_cvref_t<decltype(shape)>>)
          return 0.0;
        else
          return pdf_shape(shape, light.two_sided, context, hit);
      },
      light.shape));
  return std::isfinite(density) ? density : 0;
}

Color emitted(const Light& light, const LightContext& context, const Vec3& wi) {
  const bool front =
      light.two_sided ||
      std::visit([&](const auto& shape) { return faces(shape, context, wi); }, light.shape);
  return front ? light.radiance * share_along(light, to_double(wi)) : Color{};
}

Bounds3 bounds(const Light& light) {
  return std::visit([](const auto& shape) { return bounds_of(shape); }, light.shape);
}

EmissionCone cone(const Light& light) {
  return std::visit([&](const auto& shape) { return cone_of(shape, light.two_sided); },
                    light.shape);
}

Color power(const Light& light) {
  const double etendue =
      std::visit([](const auto& shape) { return etendue_of(shape); }, light.shape);
  return mean_radiance(light) * static_cast<float>(light.two_sided ? 2 * etendue : etendue);
}

Color intensity(const Light& light) {
  const double area =
      std::visit([](const auto& shape) { return seen_area_of(shape); }, light.shape);
  return mean_radiance(light) * static_cast<float>(area);
}

Color irradiance(const Light& light) {
  if (std::holds_alternative<DirectionalLight>(light.shape)) return light.radiance;
  if (const auto* sun = std::get_if<SunLight>(&light.shape))
    return light.radiance * static_cast<float>(sun->projected());
  if (!std::holds_alternative<EnvironmentLight>(light.shape)) return {};
  return mean_radiance(light) * pi;
}

}  // namespace tessera::render
