#include "common/scene/gltf/instancing.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/limits.hpp"
#include "common/scene/gltf/nodes.hpp"

namespace tessera::scene::gltf {

std::vector<Transform> copies_of(const Asset& asset, Accessors& accessors, int node) {
  const tinygltf::Value* instancing = extension(
      asset.model.nodes[static_cast<std::size_t>(node)].extensions, "EXT_mesh_gpu_instancing");
  if (instancing == nullptr) return {Transform{}};
  const std::string place =
      fmt::format("/nodes/{}/extensions/EXT_mesh_gpu_instancing/attributes", node);
  const tinygltf::Value& attributes = *member(*instancing, "attributes");
  const int translation = integer_or(attributes, "TRANSLATION", -1);
  const int rotation = integer_or(attributes, "ROTATION", -1);
  const int scale = integer_or(attributes, "SCALE", -1);

  std::size_t count = 0;
  for (const int accessor : {translation, rotation, scale}) {
    if (accessor < 0) continue;
    const std::size_t its = accessors.count(accessor);
    if (count != 0 && its != count)
      asset.fail(place, fmt::format("its accessors have {} and {} elements", count, its));
    count = its;
  }
  if (count == 0) return {Transform{}};
  if (count > limits::gltf_instances)
    asset.fail(place, fmt::format("{} copies; {} is the most", count, limits::gltf_instances));

  accessors.spend(count * (sizeof(Transform) + sizeof(Instance)), place);
  std::vector<std::array<float, 3>> translations, scales;
  std::vector<std::array<float, 4>> rotations;
  if (translation >= 0) translations = accessors.vectors<3>(translation, place + "/TRANSLATION");
  if (rotation >= 0) rotations = accessors.vectors<4>(rotation, place + "/ROTATION");
  if (scale >= 0) scales = accessors.vectors<3>(scale, place + "/SCALE");
  std::vector<Transform> out;
  out.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    Vec3 moved{0, 0, 0}, scaled{1, 1, 1};
    Quaternion turned{0, 0, 0, 1};
    if (translation >= 0) std::copy_n(translations[i].begin(), 3, moved.begin());
    if (rotation >= 0) std::copy_n(rotations[i].begin(), 4, turned.begin());
    if (scale >= 0) std::copy_n(scales[i].begin(), 3, scaled.begin());
    out.push_back(transform_from(moved, turned, scaled));
  }
  return out;
}

}  // namespace tessera::scene::gltf
