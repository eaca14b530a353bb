#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "common/base/error.hpp"

namespace tessera::client {

/// A folder that goes when the test ends.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  std::filesystem::path write(const std::string& name, std::string_view text) const;

 private:
  std::filesystem::path path_;
};

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
