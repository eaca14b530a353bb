#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "common/scene/description.hpp"

namespace tessera::scene {

/// What an OBJ text holds.
struct ObjCounts {
  std::size_t positions = 0, normals = 0, uvs = 0;
  std::size_t corners = 0;    ///< of all faces
  std::size_t triangles = 0;  ///< after polygons have been cut
};

/// Looks at every line of an OBJ text, and refuses what tinyobjloader would read as something else
/// without a word: numbers that are none or too large, statements that do not exist, indices that
/// name nothing, faces of fewer than three or more than `limits::polygon_corners` corners. Throws
/// Error{bad_input} with `name` and line.
ObjCounts check_obj(std::string_view text, const std::string& name);

/// All faces of an OBJ text as one mesh. Groups, objects, smoothing groups and materials in it say
/// nothing here; lines and points are passed over. Where a face has no normals and others do, its
/// corners get that of its plane.
Mesh parse_obj(std::string_view text, const std::string& name);

/// The same from a file, which errors call `name`.
Mesh read_obj(const std::filesystem::path& file, const std::string& name);

}  // namespace tessera::scene
