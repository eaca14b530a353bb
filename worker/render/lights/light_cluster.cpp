#include "worker/render/lights/light_cluster.hpp"

#include <algorithm>

#include "worker/render/fastmath.hpp"

namespace tessera::render {
namespace {

double angle_of(double cosine) { return fast::acos(std::clamp(cosine, -1.0, 1.0)); }

}  // namespace

LightCluster::LightCluster(const Light& light)
    : bounds(render::bounds(light)),
      intensity(static_cast<double>(luminance(render::intensity(light)))) {
  const EmissionCone cone = render::cone(light);
  axis = to_double(cone.axis);
  theta_o = cone.cos_theta_o == 1 ? 0 : angle_of(static_cast<double>(cone.cos_theta_o));
  theta_e = angle_of(static_cast<double>(cone.cos_theta_e));
}

void LightCluster::grow_cone(const LightCluster& other) {
  theta_e = std::max(theta_e, other.theta_e);
  if (theta_o >= pi_d) return;
  const double apart = angle_of(dot(axis, other.axis));
  if (apart + other.theta_o <= theta_o) return;
  if (apart + theta_o <= other.theta_o) {
    axis = other.axis;
    theta_o = other.theta_o;
    return;
  }
  const double both = 0.5 * (theta_o + apart + other.theta_o);
  const Vec3d around = cross(axis, other.axis);
  if (both >= pi_d || !(length_squared(around) > 0)) {
    theta_o = pi_d;
    return;
  }
  // The axis turns towards the other's, in the plane of the two.
  const auto [sine, cosine] = fast::sincos(both - theta_o);
  axis = normalize(axis * cosine + cross(normalize(around), axis) * sine);
  theta_o = both;
}

void LightCluster::grow(const LightCluster& other) {
  if (!(intensity > 0)) {
    *this = other;
    return;
  }
  bounds.grow(other.bounds);
  intensity += other.intensity;
  grow_cone(other);
}

double LightCluster::orientation() const {
  const double end = std::min(theta_o + theta_e, pi_d);
  const auto [sine, cosine] = fast::sincos(theta_o);
  const double cos_back = fast::sincos(theta_o - 2 * end).second;
  return 2 * pi_d * (1 - cosine) +
         0.5 * pi_d * (2 * end * sine - cos_back - 2 * theta_o * sine + cosine);
}

}  // namespace tessera::render
