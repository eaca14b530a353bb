#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "common/scene/description.hpp"

namespace tessera::scene {

/// The polygons of a PLY file (ASCII, binary of either byte order) as one mesh: positions, and
/// where they are there normals, texture coordinates (s, t or u, v; v runs up in the file) and
/// colours (bytes are sRGB, fractions linear). Other elements and properties are passed over;
/// polygons are cut into fans. Throws Error{bad_input} with `name` and the element.
Mesh parse_ply(std::string_view bytes, const std::string& name);
Mesh read_ply(const std::filesystem::path& file, const std::string& name);

}  // namespace tessera::scene
