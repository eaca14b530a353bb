#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "common/base/limits.hpp"
#include "common/scene/gltf/accessor.hpp"
#include "common/scene/gltf/draco.hpp"

namespace tessera::scene::gltf {

namespace {
/// True for what meshes are made of; the others may have any type.
bool is_read(std::string_view attribute) {
  constexpr std::array<std::string_view, 6> read{"POSITION",   "NORMAL",     "TANGENT",
                                                 "TEXCOORD_0", "TEXCOORD_1", "COLOR_0"};
  return std::find(read.begin(), read.end(), attribute) != read.end() ||
         attribute.starts_with("JOINTS_") || attribute.starts_with("WEIGHTS_");
}
}  // namespace

std::size_t Accessors::count(int accessor) const {
  const auto found = unpacked_.find(accessor);
  return found != unpacked_.end() ? found->second.count : of(accessor).count;
}

bool Accessors::unpack_mesh(const tinygltf::Primitive& primitive, const std::string& place) {
  constexpr const char* name = "KHR_draco_mesh_compression";
  unpacked_.clear();
  const tinygltf::Value* draco = extension(primitive.extensions, name);
  if (draco == nullptr) return false;
  const std::string here = fmt::format("{}/extensions/{}", place, name);
  if (primitive.indices < 0 || components(primitive.indices) != 1)
    asset_.fail(place + "/indices", "what is compressed with Draco needs them, each a number");
  std::vector<DracoAttribute> wanted;
  std::vector<int> wanted_for;
  for (const auto& [key, accessor] : primitive.attributes) {
    if (!is_read(key)) continue;
    const int id = integer_or(*member(*draco, "attributes"), key, -1);
    if (id < 0) continue;
    wanted.push_back({.id = static_cast<std::uint32_t>(id),
                      .component_type = of(accessor).componentType,
                      .components = components(accessor)});
    wanted_for.push_back(accessor);
  }
  const int number = integer_or(*draco, "bufferView", 0);
  const tinygltf::BufferView& view = asset_.model.bufferViews[static_cast<std::size_t>(number)];
  if (extension(view.extensions, "EXT_meshopt_compression") != nullptr)
    asset_.fail(here + "/bufferView", "a buffer view with EXT_meshopt_compression");
  if (view.byteLength > limits::gltf_unpacked)
    asset_.fail(here + "/bufferView",
                fmt::format("{} bytes; {} are the most", view.byteLength, limits::gltf_unpacked));
  std::vector<std::byte> packed(view.byteLength);
  read_bytes(view.buffer, view.byteOffset, packed);
  DracoMesh mesh;
  try {
    mesh = decode_draco(packed, wanted);
  } catch (const Error& error) {
    throw Error(error.kind(), error.message(), {.file = asset_.name, .key = here});
  }
  std::uint64_t made = mesh.corners.size() * sizeof(std::uint32_t);
  for (const auto& values : mesh.attributes) made += values.size();
  spend(made, here);
  for (std::size_t i = 0; i < wanted.size(); ++i)
    unpacked_[wanted_for[i]] = {.component_type = wanted[i].component_type,
                                .count = mesh.points,
                                .bytes = std::move(mesh.attributes[i])};
  const auto* const corners = reinterpret_cast<const std::byte*>(mesh.corners.data());
  unpacked_[primitive.indices] = {
      .component_type = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
      .count = mesh.corners.size(),
      .bytes = {corners, corners + mesh.corners.size() * sizeof(std::uint32_t)}};
  return true;
}

}  // namespace tessera::scene::gltf
