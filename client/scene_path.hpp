#pragma once
#include <string_view>

#include "common/base/json.hpp"

namespace tessera::client {

/// The value at a path of keys in a scene's JSON, written as errors about scenes write it:
/// "camera.fov", "materials.white.reflectance", "shapes[3].material". A name with a dot or a
/// bracket in it is found as well. Throws Error{bad_input} that names the nearest key if there is
/// no such value.
Json& value_at(Json& scene, std::string_view path);

}  // namespace tessera::client
