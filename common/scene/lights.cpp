#include <fmt/format.h>

#include <array>
#include <cmath>

#include "common/base/names.hpp"
#include "common/scene/parts.hpp"

namespace tessera::scene {

namespace {

using Light = decltype(PunctualLight::shape);

Vec3 direction_at(Fields& in) {
  const Value value = in.required("direction");
  const Vec3 out = value.point();
  if (!(std::hypot(out[0], out[1], out[2]) >= direction_least))
    value.fail("a direction needs a length");
  return out;
}

Light point(Fields& in) {
  PointLight out;
  out.position = in.required("position").point();
  out.intensity = in.required("intensity").color(radiance_most);
  return out;
}

Light spot(Fields& in) {
  SpotLight out;
  out.position = in.required("position").point();
  out.direction = direction_at(in);
  out.intensity = in.required("intensity").color(radiance_most);
  out.outer_degrees = in.number_or("outer_angle", 1e-3, 90, out.outer_degrees);
  const auto inner = in.optional("inner_angle");
  if (inner) out.inner_degrees = inner->number(0, 90);
  if (!(out.inner_degrees < out.outer_degrees))
    inner.value_or(in.self()).fail(
        fmt::format("the inner angle is not below the outer, {}", out.outer_degrees));
  return out;
}

/// A disk smaller than this, in degrees, is a point to single precision.
constexpr double angle_least = 0.001;

Light directional(Fields& in) {
  DirectionalLight out;
  out.direction = direction_at(in);
  out.irradiance = in.required("irradiance").color(radiance_most);
  if (const auto angle = in.optional("angle")) out.angle_degrees = angle->number(angle_least, 180);
  return out;
}

struct LightType {
  std::string_view name;
  Light (*read)(Fields&);
};
/// Every type of light that a scene can name.
constexpr std::array<LightType, 3> light_types{
    {{"point", point}, {"spot", spot}, {"directional", directional}}};

}  // namespace

std::vector<PunctualLight> read_lights(const Value& lights) {
  std::vector<std::string_view> types;
  for (const LightType& type : light_types) types.push_back(type.name);
  std::vector<PunctualLight> out;
  for (const Value& value : lights.items("a list of lights")) {
    Fields in(value);
    const std::string type = read_name(in, "type", "light type", types);
    PunctualLight light;
    light.name = in.text_or("name", fmt::format("{} {}", type, out.size()));
    for (const LightType& known : light_types)
      if (type == known.name) light.shape = known.read(in);
    light.light_group = read_light_group(in);
    in.finish();
    out.push_back(std::move(light));
  }
  return out;
}

}  // namespace tessera::scene
