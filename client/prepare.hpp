#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "client/job_options.hpp"
#include "client/overrides.hpp"
#include "common/assets/bundle.hpp"
#include "common/scene/scene_file.hpp"

namespace tessera::client {

/// The bytes that a job needs of a scene.
struct SceneAssets {
  assets::Bundle bundle;
  Digest digest;                       ///< of the bundle
  std::vector<scene::UsedFile> files;  ///< the scene's, where they are on this machine
};

/// A job that is ready to be posted.
struct PreparedJob {
  JobSpec spec;
  SceneAssets assets;
  std::vector<std::string> warnings;  ///< of the scene and the job, for the person
  std::vector<MemoryFile> edited;     ///< among the assets' files
};

/// Hashes files, each once: scenes that are edits of one another share most of theirs.
class FileHasher {
 public:
  const assets::BundleFile& entry_of(const std::filesystem::path& file);

 private:
  std::map<std::filesystem::path, assets::BundleFile> known_;
};

/// How a scene's files come to the workers.
struct ByPath {
  std::filesystem::path folder;  ///< the scene's, as it was named
};
/// The manifest of a scene's files, the scene file first among them. By path: those that lie on a
/// disk are named by where they do, as their folder was named if that is the same file.
SceneAssets assets_of(std::vector<scene::UsedFile> files, FileHasher& hasher,
                      const std::optional<ByPath>& by_path);
/// What the options say of it.
std::optional<ByPath> by_path_of(const JobOptions& options);

/// Reads the scene and all that it uses, whatever is wrong in it being an error here, and hashes
/// the files.
PreparedJob prepare(const JobOptions& options);

}  // namespace tessera::client
