#include <algorithm>
#include <cmath>

#include "worker/render/frame.hpp"
#include "worker/render/lights/environment_map.hpp"
#include "worker/render/lights/shapes.hpp"
#include "worker/render/warp.hpp"

namespace tessera::render {

namespace {

/// A sphere seen from the lit point.
struct SeenSphere {
  Vec3d center;
  double distance2, radius2;

  SeenSphere(const SphereLight& sphere, const Vec3& p)
      : center(to_double(sphere.center) - to_double(p)),
        distance2(length_squared(center)),
        radius2(static_cast<double>(sphere.radius) * sphere.radius) {}

  [[nodiscard]] bool inside() const { return distance2 <= radius2; }
  /// 1 − cos θ of the cone that holds it, from outside; sin²/(1 + cos) keeps its digits however far
  /// it is.
  [[nodiscard]] double cap_height() const {
    const double sin2 = radius2 / distance2;
    return sin2 / (1 + std::sqrt(1 - sin2));
  }
};

/// A direction uniform in a cone about `axis`; `cap` is 1 − the cosine of its half angle.
struct InCone {
  Vec3d wi;
  double sin2, cosine;  ///< of its angle from the axis

  InCone(const Vec3d& axis, double cap, Vec2 u) {
    const double height = cap * u.x;
    sin2 = height * (2 - height);
    cosine = 1 - height;
    const auto [sin_azimuth, cos_azimuth] = fast::sincos(2 * pi_d * u.y);
    const double sine = std::sqrt(sin2);
    wi = FrameD(axis).to_world({sine * cos_azimuth, sine * sin_azimuth, cosine});
  }
};
double cone_pdf(double cap) { return 1 / (2 * pi_d * cap); }

}  // namespace

ShapeSample sample_shape(const SphereLight& light, bool two_sided, const LightContext& context,
                         Vec2 u) {
  const SeenSphere sphere(light, context.p);
  if (sphere.inside()) {
    if (!two_sided) return {};
    const Vec3d wi = to_double(square_to_sphere(u));
    const double along = dot(sphere.center, wi);
    const double far = std::sqrt(std::max(0.0, along * along + sphere.radius2 - sphere.distance2));
    return {.wi = wi, .distance = along + far, .pdf = static_cast<double>(sphere_pdf())};
  }
  const double cap = sphere.cap_height();
  const double distance = std::sqrt(sphere.distance2);
  const InCone drawn(sphere.center / distance, cap, u);
  const double half_chord =
      std::sqrt(std::max(0.0, sphere.radius2 - sphere.distance2 * drawn.sin2));
  return {.wi = drawn.wi, .distance = distance * drawn.cosine - half_chord, .pdf = cone_pdf(cap)};
}

double pdf_shape(const SphereLight& light, bool two_sided, const LightContext& context,
                 const LightHit& /*hit*/) {
  const SeenSphere sphere(light, context.p);
  if (sphere.inside()) return two_sided ? static_cast<double>(sphere_pdf()) : 0;
  return cone_pdf(sphere.cap_height());
}

bool SunLight::holds(const Vec3& wi) const {
  // By the chord: the cosine of a small angle has no digits left.
  return length_squared(to_double(wi) + to_double(direction)) <= 2 * cap;
}

ShapeSample sample_shape(const SunLight& sun, bool /*two_sided*/, const LightContext& /*context*/,
                         Vec2 u) {
  return {.wi = InCone(-to_double(sun.direction), sun.cap, u).wi,
          .distance = std::numeric_limits<double>::infinity(),
          .pdf = cone_pdf(sun.cap)};
}

double pdf_shape(const SunLight& sun, bool /*two_sided*/, const LightContext& /*context*/,
                 const LightHit& hit) {
  return sun.holds(hit.wi) ? cone_pdf(sun.cap) : 0;
}

ShapeSample sample_shape(const EnvironmentLight& environment, bool /*two_sided*/,
                         const LightContext& context, Vec2 u) {
  const double far = std::numeric_limits<double>::infinity();
  if (environment.map != nullptr) {
    const EnvironmentMap::Drawn drawn = environment.map->sample(u);
    return {.wi = drawn.direction, .distance = far, .pdf = drawn.pdf, .share = drawn.radiance};
  }
  if (context.n == Vec3{}) {
    return {.wi = to_double(square_to_sphere(u)),
            .distance = far,
            .pdf = static_cast<double>(sphere_pdf())};
  }
  const Vec3 local = square_to_cosine_hemisphere(u);
  return {.wi = to_double(Frame(context.n).to_world(local)),
          .distance = far,
          .pdf = static_cast<double>(cosine_hemisphere_pdf(local))};
}

double pdf_shape(const EnvironmentLight& environment, bool /*two_sided*/,
                 const LightContext& context, const LightHit& hit) {
  if (environment.map != nullptr) return environment.map->pdf(to_double(hit.wi));
  if (context.n == Vec3{}) return static_cast<double>(sphere_pdf());
  return static_cast<double>(cosine_hemisphere_pdf({0, 0, dot(context.n, hit.wi)}));
}

}  // namespace tessera::render
