#include "client/prepare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "client/interrupt.hpp"
#include "client/preflight.hpp"
#include "common/base/limits.hpp"

namespace tessera::client {

const assets::BundleFile& FileHasher::entry_of(const std::filesystem::path& file) {
  const auto found = known_.find(file);
  if (found != known_.end()) return found->second;
  throw_if_interrupted();
  const assets::BundleFile entry{digest_of_file(file), std::filesystem::file_size(file), {}};
  return known_.emplace(file, entry).first->second;
}

namespace {
std::string location_of(const scene::UsedFile& used, const std::filesystem::path& folder) {
  const std::filesystem::path named =
      (std::filesystem::absolute(folder) / used.path).lexically_normal();
  std::error_code error;
  const bool same = std::filesystem::equivalent(named, used.file, error);
  return same ? named.string() : std::filesystem::absolute(used.file).string();
}
}  // namespace

SceneAssets assets_of(std::vector<scene::UsedFile> files, FileHasher& hasher,
                      const std::optional<ByPath>& by_path) {
  SceneAssets out;
  out.bundle.scene = files.front().path;
  for (const scene::UsedFile& used : files) {
    assets::BundleFile& entry = out.bundle.files[used.path];
    entry = hasher.entry_of(used.file);
    if (by_path && !MemoryFile::is_one(used.file))
      entry.location = location_of(used, by_path->folder);
  }
  assets::check(out.bundle);
  out.digest = assets::digest_of_bundle(out.bundle);
  out.files = std::move(files);
  return out;
}

std::optional<ByPath> by_path_of(const JobOptions& options) {
  if (!options.by_path) return std::nullopt;
  return ByPath{options.scene.parent_path()};
}

namespace {
/// The frames of all that moves, for one who asked for none.
std::string motion_note(double duration, double fps) {
  constexpr double most = limits::frame_max;
  const double last = std::min(std::floor(duration * fps + 1e-6) + 1, most);
  return fmt::format(
      "the scene moves for {:.4g} s, and this is its first moment: --frames 1-{:.0f} renders it at "
      "{:g} frames a second",
      duration, last, fps);
}
}  // namespace

PreparedJob prepare(const JobOptions& options) {
  NamedScene named = named_scene(options.scene, options.overrides);
  scene::LoadedScene loaded = survey_named_scene(named);
  Preflight().check(loaded);
  PreparedJob out;
  out.warnings = std::move(loaded.warnings);
  // What is wrong with it is said before files are hashed.
  out.spec = job_from(loaded.scene, options, Digest{}, &out.warnings);
  if (loaded.duration > 0 && !options.frames)
    out.warnings.push_back(motion_note(loaded.duration, out.spec.fps));
  FileHasher hasher;
  out.assets = assets_of(std::move(loaded.files), hasher, by_path_of(options));
  out.spec.bundle = out.assets.digest;
  out.edited = std::move(named.edited);
  return out;
}

}  // namespace tessera::client
