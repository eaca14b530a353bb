#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/scene/scene_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tessera::scene {

/// A glTF file that grows by calls. `json` may be changed in any way before it is written.
class GltfFile {
 public:
  GltfFile();

  nlohmann::json json;

  /// Bytes at the end of the one buffer, and a buffer view of them. The view's number.
  template <class T>
  int view(const std::vector<T>& values) {
    return view_of(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  /// The number of an accessor of `type` ("VEC3") over new bytes.
  template <class T>
  int accessor(const std::vector<T>& values, const std::string& type, int component_type) {
    return accessor_of(view(values), values.size(), type, component_type);
  }
  int floats(const std::vector<float>& values, const std::string& type) {
    return accessor(values, type, 5126);
  }
  int indices(const std::vector<std::uint16_t>& values) { return accessor(values, "SCALAR", 5123); }

  /// A mesh of one primitive with these members; its number.
  int mesh(const nlohmann::json& primitive);
  /// A node of the scene's; its number.
  int node(const nlohmann::json& members);
  /// The corners (0,0,0), (1,0,0), (0,1,0) as a mesh on a node: all that a picture needs.
  GltfFile& with_triangle();

  [[nodiscard]] std::string glb() const;
  /// With the buffer as a data URI.
  [[nodiscard]] std::string text() const;
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

  /// Writes a .glb and reads it back.
  [[nodiscard]] LoadedScene load() const;

 private:
  int view_of(const char* data, std::size_t size);
  int accessor_of(int view, std::size_t values, const std::string& type, int component_type);

  std::string bytes_;
};

/// A .glb around any two chunks.
std::string glb_of(std::string json, std::string binary);
std::string base64(const std::string& bytes);

/// The error that reading `bytes` as a file of this name gives; fails the test if there is none.
Error error_of_bytes(const std::string& bytes, const std::string& name = "model.glb");
const Mesh& mesh_of(const Shape& shape);

}  // namespace tessera::scene
