#pragma once
#include <span>
#include <type_traits>

#include "worker/render/lights/light.hpp"

/// Each shape's way to draw a direction towards it. Inside, everything is double and seen from the
/// point that is lit; a tiny or far light keeps its digits, and the shadow ray's float direction is
/// rounded once.
namespace tessera::render {

/// pdf 0: there is no direction from here.
struct ShapeSample {
  Vec3d wi;  ///< unit
  double distance = 0;
  double pdf = 0;         ///< per solid angle
  Color share = gray(1);  ///< of the light's radiance that comes this way
};

// `two_sided`: directions towards the back are wanted too. The pdf functions want the same, and wi
// as of a hit.
ShapeSample sample_shape(const QuadLight& quad, bool two_sided, const LightContext& context,
                         Vec2 u);
double pdf_shape(const QuadLight& quad, bool two_sided, const LightContext& context,
                 const LightHit& hit);

/// A rectangle that is to be sampled.
struct RectangleRequest {
  const QuadLight* light = nullptr;
  bool two_sided = false;
  const LightContext* context = nullptr;
  Vec2 u;
};
/// As sample_shape() for each, up to WideDouble::lanes of them side by side; drawn[i] answers
/// asked[i].
void sample_rectangles(std::span<const RectangleRequest> asked, std::span<ShapeSample> drawn);

ShapeSample sample_shape(const DiskLight& disk, bool two_sided, const LightContext& context,
                         Vec2 u);
double pdf_shape(const DiskLight& disk, bool two_sided, const LightContext& context,
                 const LightHit& hit);

ShapeSample sample_shape(const TriangleLight& triangle, bool two_sided, const LightContext& context,
                         Vec2 u);
double pdf_shape(const TriangleLight& triangle, bool two_sided, const LightContext& context,
                 const LightHit& hit);

ShapeSample sample_shape(const SphereLight& sphere, bool two_sided, const LightContext& context,
                         Vec2 u);
double pdf_shape(const SphereLight& sphere, bool two_sided, const LightContext& context,
                 const LightHit& hit);

ShapeSample sample_shape(const EnvironmentLight& environment, bool two_sided,
                         const LightContext& context, Vec2 u);
double pdf_shape(const EnvironmentLight& environment, bool two_sided, const LightContext& context,
                 const LightHit& hit);

ShapeSample sample_shape(const SunLight& sun, bool two_sided, const LightContext& context, Vec2 u);
double pdf_shape(const SunLight& sun, bool two_sided, const LightContext& context,
                 const LightHit& hit);

// Without a size: their pdf is 1, and no hit is ever theirs.
ShapeSample sample_shape(const PointLight& point, bool two_sided, const LightContext& context,
                         Vec2 u);
ShapeSample sample_shape(const SpotLight& spot, bool two_sided, const LightContext& context,
                         Vec2 u);
ShapeSample sample_shape(const DirectionalLight& light, bool two_sided, const LightContext& context,
                         Vec2 u);

template <class Shape>
constexpr bool is_delta = std::is_same_v<Shape, PointLight> || std::is_same_v<Shape, SpotLight> ||
                          std::is_same_v<Shape, DirectionalLight>;

}  // namespace tessera::render
