#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "common/scene/texture.hpp"

namespace tessera::scene::gltf {

/// A .gltf or .glb file, taken apart: which of the two it is, its first bytes tell.
struct Container {
  std::string json;
  /// The binary chunk of a .glb, where it lies in the file.
  std::optional<FileRange> binary;
};

/// Throws Error{bad_input} with `name` for a .glb of another version, or one whose lengths do not
/// fit each other or the file; what is too large as read_file says it.
Container read_container(const std::filesystem::path& file, const std::string& name);

}  // namespace tessera::scene::gltf
