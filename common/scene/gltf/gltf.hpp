#pragma once
#include <string>
#include <string_view>

#include "common/scene/scene_file.hpp"

/// The way into glTF 2.0: .gltf with files or data URIs, .glb.
namespace tessera::scene::gltf {

/// By the ending of its name.
bool is_gltf(std::string_view path);

/// Reads the file `path`, checked_path's spelling, and all that it names. Without `meshes`, no
/// vertex is read. Throws Error with the file and a JSON pointer. What is in the file and cannot be
/// shown is a warning; so is what was made up: a camera, light.
LoadedScene load(const SceneFiles& files, const std::string& path, bool meshes);

}  // namespace tessera::scene::gltf
