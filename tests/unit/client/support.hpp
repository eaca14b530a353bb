#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "common/base/error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tessera::client {

/// The error that `action` throws; fails the test if there is none.
Error error_of(const std::function<void()>& action);

/// A scene with one sphere.
inline constexpr std::string_view small_scene =
    R"({"tessera": 1, "name": "Ball", "film": {"width": 40, "height": 30},
  "render": {"samples": 9, "bounces": 3, "filter": "tent", "seed": 5},
  "cameras": [{"name": "left", "eye": [-1, 0, 5], "target": [0, 0, 0]}, {"name": "right", "eye": [1, 0, 5], "target": [0, 0, 0]}],
  "materials": {"m": {"type": "diffuse"}},
  "shapes": [{"type": "sphere", "material": "m"}, {"type": "mesh", "material": "m", "file": "meshes/a.obj"}]})";
inline constexpr std::string_view small_mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

}  // namespace tessera::client
