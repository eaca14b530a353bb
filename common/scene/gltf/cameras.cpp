#include "common/scene/gltf/cameras.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

#include "common/base/names.hpp"

namespace tessera::scene::gltf {

namespace {

constexpr double degrees_per_radian = 180.0 / 3.14159265358979323846;
constexpr std::size_t name_bytes = 100;

/// A column of the linear part with length 1; nothing if it has none.
std::optional<Vec3> axis_of(const Transform& t, std::size_t column) {
  Vec3 out{t.m[column], t.m[4 + column], t.m[8 + column]};
  const double size = std::hypot(out[0], out[1], out[2]);
  if (!(size > 0) || !std::isfinite(size)) return std::nullopt;
  for (double& x : out) x /= size;
  return out;
}

/// Gives each camera a name that no other has.
class CameraNames {
 public:
  std::string next(const std::string& wanted) {
    const std::string base = wanted.empty() ? "camera" : excerpt(wanted, name_bytes);
    std::string name = base;
    int& number = last_number_[base];
    number = std::max(number, 1);
    while (!taken_.insert(name).second) name = fmt::format("{} {}", base, ++number);
    return name;
  }

 private:
  std::unordered_set<std::string> taken_;
  std::unordered_map<std::string, int> last_number_;  ///< of those that wanted one name
};

}  // namespace

std::vector<Camera> read_cameras(Asset& asset, const std::vector<PlacedNode>& nodes) {
  std::vector<Camera> out;
  CameraNames names;
  for (const PlacedNode& placed : nodes) {
    const tinygltf::Node& node = asset.model.nodes[static_cast<std::size_t>(placed.node)];
    if (node.camera < 0) continue;
    const tinygltf::Camera& from = asset.model.cameras[static_cast<std::size_t>(node.camera)];
    const auto up = axis_of(placed.to_world, 1), back = axis_of(placed.to_world, 2);
    if (!up || !back || is_singular(placed.to_world)) {
      asset.warn(
          fmt::format("the camera of /nodes/{} is scaled to nothing, and left out", placed.node));
      continue;
    }
    Camera camera;
    camera.name = names.next(node.name.empty() ? from.name : node.name);
    const auto& m = placed.to_world.m;
    camera.eye = {m[3], m[7], m[11]};
    camera.up = *up;
    // As far off as the eye is from the origin, so that the difference keeps its digits.
    const double distance = std::max({1.0, std::abs(m[3]), std::abs(m[7]), std::abs(m[11])});
    for (std::size_t i = 0; i < 3; ++i) camera.target[i] = camera.eye[i] - (*back)[i] * distance;
    if (from.type == "orthographic") {
      camera.projection = Projection::orthographic;
      camera.orthographic_height = 2 * std::abs(from.orthographic.ymag);
      if (!(camera.orthographic_height > 0))
        asset.fail(fmt::format("/cameras/{}/orthographic/ymag", node.camera), "may not be 0");
    } else {
      camera.fov_y_degrees = from.perspective.yfov * degrees_per_radian;
    }
    out.push_back(std::move(camera));
  }
  return out;
}

std::optional<double> aspect_of_first(const Asset& asset, const std::vector<PlacedNode>& nodes) {
  for (const PlacedNode& placed : nodes) {
    const int camera = asset.model.nodes[static_cast<std::size_t>(placed.node)].camera;
    if (camera < 0) continue;
    const tinygltf::Camera& from = asset.model.cameras[static_cast<std::size_t>(camera)];
    if (from.type == "orthographic" && from.orthographic.ymag != 0)
      return std::abs(from.orthographic.xmag / from.orthographic.ymag);
    if (from.perspective.aspectRatio > 0) return from.perspective.aspectRatio;
    return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace tessera::scene::gltf
