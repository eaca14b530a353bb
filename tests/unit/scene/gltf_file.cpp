#include "tests/unit/scene/gltf_file.hpp"

#include <gtest/gtest.h>

namespace tessera::scene {

namespace {

std::string word(std::size_t value) {
  const auto narrow = static_cast<std::uint32_t>(value);
  std::string out(4, '\0');
  std::memcpy(out.data(), &narrow, 4);
  return out;
}

std::size_t components_of(const std::string& type) {
  if (type == "SCALAR") return 1;
  const auto side = static_cast<std::size_t>(type.back() - '0');
  return type.starts_with("MAT") ? side * side : side;
}

}  // namespace

GltfFile::GltfFile() {
  json = {{"asset", {{"version", "2.0"}}},
          {"scene", 0},
          {"scenes", {{{"nodes", nlohmann::json::array()}}}}};
}

int GltfFile::view_of(const char* data, std::size_t size) {
  bytes_.resize((bytes_.size() + 3) / 4 * 4);
  json["bufferViews"].push_back(
      {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", size}});
  bytes_.append(data, size);
  json["buffers"] = {{{"byteLength", bytes_.size()}}};
  return static_cast<int>(json["bufferViews"].size()) - 1;
}

int GltfFile::accessor_of(int view, std::size_t values, const std::string& type,
                          int component_type) {
  json["accessors"].push_back({{"bufferView", view},
                               {"componentType", component_type},
                               {"count", values / components_of(type)},
                               {"type", type}});
  return static_cast<int>(json["accessors"].size()) - 1;
}

int GltfFile::mesh(const nlohmann::json& primitive) {
  json["meshes"].push_back({{"primitives", {primitive}}});
  return static_cast<int>(json["meshes"].size()) - 1;
}

int GltfFile::node(const nlohmann::json& members) {
  json["nodes"].push_back(members);
  const int number = static_cast<int>(json["nodes"].size()) - 1;
  json["scenes"][0]["nodes"].push_back(number);
  return number;
}

GltfFile& GltfFile::with_triangle() {
  const int positions = floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
  node({{"mesh", mesh({{"attributes", {{"POSITION", positions}}}})}});
  return *this;
}

std::string GltfFile::glb() const { return glb_of(json.dump(), bytes_); }

std::string GltfFile::text() const {
  nlohmann::json out = json;
  out["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64(bytes_);
  return out.dump();
}

LoadedScene GltfFile::load() const {
  const TemporaryFolder folder;
  return load_scene(folder.write("model.glb", glb()));
}

std::string glb_of(std::string json, std::string binary) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4);
  std::string out = "glTF" + word(2) + word(12 + 8 + json.size() + 8 + binary.size());
  out += word(json.size()) + "JSON" + json;
  out += word(binary.size()) + std::string("BIN\0", 4) + binary;
  return out;
}

std::string base64(const std::string& bytes) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k > bytes.size() ? '=' : digits[bits >> (18 - 6 * k) & 63];
  }
  return out;
}

Error error_of_bytes(const std::string& bytes, const std::string& name) {
  const TemporaryFolder folder;
  const auto file = folder.write(name, bytes);
  try {
    (void)load_scene(file);
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "no error";
  return Error(ErrorKind::failed, "none");
}

const Mesh& mesh_of(const Shape& shape) { return std::get<Mesh>(shape.geometry); }

}  // namespace tessera::scene
