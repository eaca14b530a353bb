#pragma once
#include <cstdint>
#include <limits>
#include <span>
#include <variant>

#include "worker/render/vec.hpp"

/// What emits, and how directions towards it are drawn. Densities are per unit of solid angle at
/// the point that is lit.
namespace tessera::render {

/// Parallelogram corner + s·edge_u + t·edge_v; it emits on the side of edge_u × edge_v.
struct QuadLight {
  Vec3 corner, edge_u, edge_v;
  double inverse_length_u = 0, inverse_length_v = 0;
  bool rectangle = false;  ///< its angles are right, but for what rounding leaves in float

  QuadLight() = default;
  QuadLight(const Vec3& corner_, const Vec3& edge_u_, const Vec3& edge_v_);
};
/// Ellipse center + s·axis_u + t·axis_v, s² + t² ≤ 1; it emits on the side of axis_u × axis_v.
struct DiskLight {
  Vec3 center, axis_u, axis_v;
  bool circle = false;  ///< its axes are alike and at right angles, but for rounding in float

  DiskLight() = default;
  DiskLight(const Vec3& center_, const Vec3& axis_u_, const Vec3& axis_v_);
};
/// It emits on the side of (b − a) × (c − a).
struct TriangleLight {
  Vec3 a, b, c;
};
/// It emits outwards.
struct SphereLight {
  Vec3 center;
  float radius = 1;
};
class EnvironmentMap;
/// From every direction, infinitely far: constant, or a picture's times the light's radiance.
struct EnvironmentLight {
  Vec3 center;       ///< of the scene
  float radius = 1;  ///< of a sphere around the scene: what it sends through that is its power
  const EnvironmentMap* map = nullptr;  ///< Scene::environment_map, or none
};
/// A disk infinitely far, of even radiance, as the sun is.
struct SunLight {
  Vec3 direction{0, -1, 0};  ///< unit, from its middle
  double cap = 0.5;          ///< 1 − cosine of the angle from its middle to its rim
  float radius = 1;          ///< as in DirectionalLight

  /// What a surface that faces it gets of radiance 1: π·sin².
  [[nodiscard]] double projected() const { return pi_d * cap * (2 - cap); }
  [[nodiscard]] bool holds(const Vec3& wi) const;
};
/// These three have no size: sample() gives the one direction there is, and `delta` says that no
/// ray finds it. Their `radiance` is intensity (W·sr⁻¹) or, of the last, irradiance (W·m⁻²).
struct PointLight {
  Vec3 position;
};
/// Full within the inner cone; then by the square of (cos θ − cos outer) / (cos inner − cos outer),
/// as KHR_lights_punctual has it.
struct SpotLight {
  Vec3 position;
  Vec3 axis{0, 0, -1};  ///< unit, in which it shines
  float cos_inner = 1, cos_outer = 0.7071068F;
};
struct DirectionalLight {
  Vec3 direction{0, -1, 0};  ///< unit, in which it shines
  float radius = 1;  ///< of a sphere around the scene: what it sends through that is its power
};

constexpr std::uint32_t no_id = 0xffffffffU;

struct Light {
  std::variant<QuadLight, TriangleLight, SphereLight, EnvironmentLight, PointLight, SpotLight,
               DirectionalLight, SunLight, DiskLight>
      shape;
  Color radiance;
  bool two_sided = false;
  /// `radiance` is only a mean over the light: what leaves a point is asked of its surface
  /// (light_point.hpp).
  bool varies = false;
  std::uint16_t group = 0;         ///< light group, for separate output
  std::uint32_t instance = no_id;  ///< what a ray that hits it reports
  std::uint32_t geometry = no_id;
  std::uint32_t primitive = no_id;
  /// So far from `shape` may lie what rays meet of it: of two triangles that rounding keeps from
  /// being a parallelogram.
  float uneven = 0;
};

/// Where light is asked for.
struct LightContext {
  Vec3 p;
  /// Unit normal on the side of wo, where the surface scatters on that side alone; zero in a medium
  /// and where light may come from all sides. The environment is sampled by the cosine against it,
  /// others may take it for a hint.
  Vec3 n;
  std::uint32_t medium = no_id;
};

/// A direction towards a light; pdf 0 means that there is none (the light is edge-on or turned
/// away).
struct LightSample {
  Vec3 wi;                                                  ///< unit, from p to the light
  float distance = std::numeric_limits<float>::infinity();  ///< to the sampled point
  Color
      radiance;  ///< that leaves it towards p, if nothing stands between; where it varies, its mean
  float pdf = 0;  ///< of wi, by this light alone, per solid angle; of a delta, 1
  /// The light has no size: `radiance` stands for the irradiance of a surface that faces it, and no
  /// other way finds the light.
  bool delta = false;
  std::uint32_t light = no_id;  ///< index in the table, where a table was asked
  std::uint32_t instance = no_id;
  std::uint32_t primitive = no_id;

  explicit operator bool() const { return pdf > 0; }
};

/// A point of a light that was found by other means (by following a BSDF's sample).
struct LightHit {
  Vec3 wi;                                                  ///< unit, from p to the light
  float distance = std::numeric_limits<float>::infinity();  ///< to the hit
  std::uint32_t instance = no_id;
  std::uint32_t primitive = no_id;
};

/// Directions in which a light emits: within `theta_o` of the axis lie its normals, and `theta_e`
/// further the emission ends (Conty and Kulla, "Importance Sampling of Many Lights", 2018). As
/// cosines.
struct EmissionCone {
  Vec3 axis{0, 0, 1};
  float cos_theta_o = -1;
  float cos_theta_e = 0;
};

LightSample sample(const Light& light, const LightContext& context, Vec2 u);
/// Which light is to be sampled, from where, by which numbers.
struct LightDraw {
  const Light* light = nullptr;  ///< none: the answer's pdf is 0
  const LightContext* context = nullptr;
  Vec2 u;
};
/// The same for many at once, in less time for each, with the same bits: found[i] answers asked[i].
void sample(std::span<const LightDraw> asked, std::span<LightSample> found);
/// The density with which sample() gives hit.wi from context.p; 0 where it never does. The hit must
/// be a point of the light.
float pdf(const Light& light, const LightContext& context, const LightHit& hit);
/// The radiance that leaves a point of the light towards p against wi: by which side p sees.
Color emitted(const Light& light, const LightContext& context, const Vec3& wi);

/// Empty for what is infinitely far.
Bounds3 bounds(const Light& light);
EmissionCone cone(const Light& light);
/// Watts, per channel; of what is infinitely far, through the sphere around the scene.
Color power(const Light& light);
/// W·sr⁻¹, per channel, in the direction in which it is greatest; black for what is infinitely far.
Color intensity(const Light& light);
/// W·m⁻², per channel, that what is infinitely far gives a surface which faces it, or sees half of
/// it; black for what is not.
Color irradiance(const Light& light);

}  // namespace tessera::render
