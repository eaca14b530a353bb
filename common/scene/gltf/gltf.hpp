#pragma once
#include <string>
#include <string_view>

#include "common/scene/scene_file.hpp"

/// The way into glTF 2.0: .gltf with files or data URIs, .glb.
namespace tessera::scene::gltf {

/// By the ending of its name.
bool is_gltf(std::string_view path);

struct Options {
  bool meshes = true;  ///< else no vertex is read
  bool whole = true;   ///< a camera and light are made up where the file has none, with a warning
};

/// Reads the file `path`, checked_path's spelling, and all that it names. Throws Error with the
/// file and a JSON pointer. What is in the file and cannot be shown is a warning.
LoadedScene load(const SceneFiles& files, const std::string& path, const Options& options);

}  // namespace tessera::scene::gltf
