#include "common/scene/gltf/lights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/names.hpp"

namespace tessera::scene::gltf {

namespace {

constexpr double degrees_per_radian = 180.0 / 3.14159265358979323846;
/// Luminous efficacy that Blender's exporter takes for all light, lm/W.
constexpr double lumens_per_watt = 683;
/// Of the outer cone's angle; where both are one, its edge is sharp.
constexpr double inner_most = 0.9999;

PunctualLight light_of(const tinygltf::Light& from, const Transform& to_world, Units units) {
  const auto& m = to_world.m;
  const Vec3 position{m[3], m[7], m[11]};
  const Vec3 direction{-m[2], -m[6], -m[10]};
  Color color{1, 1, 1};
  if (from.color.size() == 3) std::copy_n(from.color.begin(), 3, color.begin());
  for (double& channel : color)
    channel *= from.intensity / (units == Units::blender ? lumens_per_watt : 1);
  PunctualLight out;
  out.name = from.name.empty() ? from.type : excerpt(from.name, 120);
  if (from.type == "directional") {
    out.shape = DirectionalLight{.direction = direction, .irradiance = color};
  } else if (from.type == "spot") {
    const double outer = from.spot.outerConeAngle * degrees_per_radian;
    out.shape = SpotLight{.position = position,
                          .direction = direction,
                          .intensity = color,
                          .inner_degrees = std::min(from.spot.innerConeAngle * degrees_per_radian,
                                                    outer * inner_most),
                          .outer_degrees = std::min(outer, 90.0)};
  } else {
    out.shape = PointLight{.position = position, .intensity = color};
  }
  return out;
}

bool has_direction(const Transform& t) {
  const double size = std::hypot(t.m[2], t.m[6], t.m[10]);
  return size > 0 && std::isfinite(size);
}

}  // namespace

std::vector<PunctualLight> read_lights(Asset& asset, const std::vector<PlacedNode>& nodes,
                                       Units units) {
  std::vector<PunctualLight> out;
  for (const PlacedNode& placed : nodes) {
    const tinygltf::Node& node = asset.model.nodes[static_cast<std::size_t>(placed.node)];
    const tinygltf::Value* light = extension(node.extensions, "KHR_lights_punctual");
    if (light == nullptr) continue;
    const tinygltf::Light& from =
        asset.model.lights[static_cast<std::size_t>(integer_or(*light, "light", 0))];
    const bool dark =
        from.intensity == 0 ||
        (from.color.size() == 3 && *std::max_element(from.color.begin(), from.color.end()) == 0);
    if (dark) continue;
    if (from.type != "point" && !has_direction(placed.to_world)) {
      asset.warn(
          fmt::format("the light of /nodes/{} is scaled to nothing, and left out", placed.node));
      continue;
    }
    if (from.range > 0)
      asset.warn("ranges of lights are passed over: light falls off with the square of its way");
    out.push_back(light_of(from, placed.to_world, units));
  }
  return out;
}

}  // namespace tessera::scene::gltf
