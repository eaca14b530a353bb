#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"
#include "common/scene/description.hpp"
#include "common/scene/made_up.hpp"

/// Reading scenes. scenes/README.md is the format's reference.
namespace tessera::scene {

/// Where a scene's files are. A path within a scene is relative to the scene's folder, with '/'
/// between its parts, and names nothing outside it: see checked_path().
class SceneFiles {
 public:
  virtual ~SceneFiles() = default;
  /// The file on this machine that holds the bytes of `path`. Throws Error{not_found} if the scene
  /// has no such file, and Error{bad_input} if the path leads outside.
  [[nodiscard]] virtual std::filesystem::path locate(const std::string& path) const = 0;
  /// How errors call the file `path`: as a person would find it.
  [[nodiscard]] virtual std::string shown(const std::string& path) const = 0;
};

/// The files of a scene that lies in a plain folder. Symbolic links that lead outside the folder
/// are refused.
class FolderFiles : public SceneFiles {
 public:
  explicit FolderFiles(const std::filesystem::path& folder);
  [[nodiscard]] std::filesystem::path locate(const std::string& path) const override;
  [[nodiscard]] std::string shown(const std::string& path) const override;

 private:
  std::filesystem::path folder_;
};

/// The files of a scene that came as a bundle: path in the scene → file on disk (a blob). Nothing
/// else can be named.
class BundleFiles : public SceneFiles {
 public:
  explicit BundleFiles(std::map<std::string, std::filesystem::path> files);
  [[nodiscard]] std::filesystem::path locate(const std::string& path) const override;
  [[nodiscard]] std::string shown(const std::string& path) const override;

 private:
  std::map<std::string, std::filesystem::path> files_;
};

/// A path that stays within its scene, in its one spelling ("./a//b.obj" becomes "a/b.obj"). Throws
/// Error{bad_input} for one that is empty, absolute, longer than limits::bundle_path, or has "..",
/// a backslash or a control character in it.
std::string checked_path(std::string_view path);

/// A file that a scene uses.
struct UsedFile {
  std::string path;            ///< in the scene
  std::filesystem::path file;  ///< on this machine
};

/// What is kept of the meshes that were read and checked.
enum class Keep : std::uint8_t { meshes, outlines };

/// When a scene is looked at.
struct Moment {
  double time = 0;                ///< seconds
  std::optional<MadeUp> made_up;  ///< LoadedScene's, of the time 0; else this is where it begins
};

struct LoadedScene {
  Scene scene;
  std::vector<UsedFile>
      files;  ///< the scene file first, then what it names, each once, in the order of first use
  /// When what moves comes to rest, in seconds; 0: nothing moves.
  double duration = 0;
  MadeUp made_up;
  /// What the scene asks for and is not supported, and what was made up for it; whole sentences.
  std::vector<std::string> warnings;
  /// What glTF files offer: variants of their materials, animations.
  std::vector<std::string> variants, animations;
  /// Of files that are not there or cannot be read, each at the place that names it. The scene
  /// lacks what is in them; survey_scene() alone gives such a scene.
  std::vector<Error> problems;
};

/// Reads the scene file `path` and all that it uses: glTF where its name ends in .gltf or .glb,
/// else our JSON. What moves stands where it is at `moment`. Throws Error with file, line, column
/// and key.
LoadedScene load_scene(const SceneFiles& files, const std::string& path, const Moment& moment = {});

/// The scene file at `file`, in a plain folder: its folder is the scene's.
LoadedScene load_scene(const std::filesystem::path& file);

/// Reads and checks all of it like load_scene(), but goes on behind a file that is not there or
/// cannot be read, so that all of them can be said at once, and keeps no more of a mesh than its
/// outline: it takes the memory of the largest one, however many there are.
LoadedScene survey_scene(const SceneFiles& files, const std::string& path);

/// One error that lists them, the first hundred, each once; the first as it is if there is no
/// other. Not for an empty list.
Error as_one(const std::vector<Error>& problems);

/// Parses a scene from memory; `name` stands in errors, `files` has what it names.
Scene parse_scene(std::string_view text, const std::string& name, const SceneFiles& files);

}  // namespace tessera::scene
