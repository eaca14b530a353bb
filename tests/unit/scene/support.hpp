#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "common/base/error.hpp"
#include "common/scene/scene_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tessera::scene {

/// The checkout's folder.
std::filesystem::path source_folder();
std::string text_of_file(const std::filesystem::path& file);

/// Parses a scene that uses no files.
Scene parse(std::string_view text);
/// A scene with a camera and what else is given: members of its root object, each with a comma
/// behind it.
std::string scene_with(std::string_view members);

/// The error that parsing `text` gives; fails the test if there is none.
Error error_of(std::string_view text);

}  // namespace tessera::scene
