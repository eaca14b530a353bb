#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "common/scene/scene_file.hpp"

/// The way into glTF 2.0: .gltf with files or data URIs, .glb.
namespace tessera::scene::gltf {

/// By the ending of its name.
bool is_gltf(std::string_view path);

/// What numbers of lights without a size mean; those of emission and environments stand as they
/// are.
enum class Units : std::uint8_t {
  physical,  ///< candela and lux, as the specification says
  blender    ///< watts that Blender's exporter multiplied by 683 lm/W: divided by it again
};
constexpr std::array<std::pair<std::string_view, Units>, 2> unit_names{
    {{"physical", Units::physical}, {"blender", Units::blender}}};

struct Options {
  bool whole = true;  ///< a camera and light are made up where the file has none, with a warning
  std::optional<std::string> variant = {};  ///< of KHR_materials_variants; else the default
  Units units = Units::physical;
  Moment moment = {};
  Keep keep = Keep::meshes;
};

/// Reads the file `path`, checked_path's spelling, and all that it names. Throws Error with the
/// file and a JSON pointer. What is in the file and cannot be shown is a warning. Files that it
/// names and that are not there are problems, and there is nothing in the scene then but its other
/// pictures.
LoadedScene load(const SceneFiles& files, const std::string& path, const Options& options);

}  // namespace tessera::scene::gltf
