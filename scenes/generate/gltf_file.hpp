#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace tessera::generate {

/// What a buffer view is for.
enum class Target : std::uint16_t { other = 0, vertices = 34962, indices = 34963 };

/// A glTF 2.0 file of one scene while it is put together, with one buffer.
class GltfFile {
 public:
  explicit GltfFile(const std::string& scene);

  /// Adds an object to one of the top level's lists; its index there.
  int add(const char* list, nlohmann::json object);
  /// Adds a node to the scene.
  void add_node(nlohmann::json node);
  /// A mesh on a node of the scene's, with these members more.
  void place(const std::string& name, nlohmann::json primitives, nlohmann::json node);
  void use_extension(const char* name) { json_["extensionsUsed"].push_back(name); }

  /// Numbers, or arrays of them.
  template <class T>
  int accessor(const std::vector<T>& values, Target target, bool normalized = false) {
    using Shape = ShapeOf<T>;
    nlohmann::json out{{"bufferView", view(std::as_bytes(std::span(values)), target)},
                       {"componentType", Shape::component_type},
                       {"count", values.size()},
                       {"type", Shape::type}};
    if (normalized) out["normalized"] = true;
    return add("accessors", std::move(out));
  }
  /// Of positions: glTF asks for their bounds.
  int positions(const std::vector<std::array<float, 3>>& values);
  /// A texture that repeats.
  int texture(const std::string& name, std::span<const std::byte> png);

  /// NAME.gltf and NAME.bin, or NAME.glb. Throws Error{failed} with the file's name.
  void write_gltf(const std::filesystem::path& folder, const std::string& name);
  void write_glb(const std::filesystem::path& folder, const std::string& name);

 private:
  template <class T>
  struct ShapeOf;
  int view(std::span<const std::byte> bytes, Target target);

  nlohmann::json json_;
  std::vector<std::byte> bytes_;
};

template <>
struct GltfFile::ShapeOf<float> {
  static constexpr int component_type = 5126;
  static constexpr const char* type = "SCALAR";
};
template <>
struct GltfFile::ShapeOf<std::int16_t> {
  static constexpr int component_type = 5122;
  static constexpr const char* type = "SCALAR";
};
template <>
struct GltfFile::ShapeOf<std::uint32_t> {
  static constexpr int component_type = 5125;
  static constexpr const char* type = "SCALAR";
};
template <class T, std::size_t Size>
struct GltfFile::ShapeOf<std::array<T, Size>> {
  static constexpr int component_type = ShapeOf<T>::component_type;
  static constexpr std::array<const char*, 3> vectors{"VEC2", "VEC3", "VEC4"};
  static constexpr const char* type = vectors[Size - 2];
};

}  // namespace tessera::generate
