#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "client/memory_file.hpp"
#include "client/overlay.hpp"

namespace tessera::client {

/// What a command line says of a scene in place of its file.
struct SceneOverrides {
  std::optional<std::string> environment;  ///< a picture's file, R,G,B, one number, or "studio"
  std::optional<double> environment_strength;
  std::optional<double> environment_rotation;  ///< degrees
  std::optional<std::string> variant;          ///< of materials, in glTF files
  std::optional<std::string> units;            ///< of their lights without a size

  [[nodiscard]] bool any() const {
    return environment || environment_strength || environment_rotation || variant || units;
  }
};

/// A scene as a command is to render it: its file, or a document of ours that says the same and
/// the overrides. Lives as long as the scene's files are read.
struct NamedScene {
  OverlayFiles files;
  std::string path;                ///< of the scene file, in `files`
  std::vector<MemoryFile> edited;  ///< the document, which is in memory and nowhere else
  std::string document;            ///< its text; empty where it is the file itself
};

/// Without overrides the file as it stands; a JSON scene has its keys replaced; a glTF file is
/// included by a document beside it. Throws Error{bad_input} that names the flag.
NamedScene named_scene(const std::filesystem::path& scene, const SceneOverrides& overrides);

/// As survey_scene(). An error in the document has no line of any file; the keys are said.
scene::LoadedScene survey_named_scene(const NamedScene& scene);

/// As survey_scene(), of a scene that a command names; one that is not there is bad input like any
/// other.
scene::LoadedScene survey_named_scene(const scene::SceneFiles& files, const std::string& path);

}  // namespace tessera::client
