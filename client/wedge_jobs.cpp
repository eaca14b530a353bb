#include "client/wedge_jobs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/files.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"

namespace tessera::client {

namespace fs = std::filesystem;

namespace {

/// A scene's folder, in which another file stands for the scene file.
class EditedFiles : public scene::SceneFiles {
 public:
  EditedFiles(const fs::path& scene, fs::path edited)
      : folder_(scene.parent_path()),
        name_(scene::checked_path(scene.filename().string())),
        edited_(std::move(edited)) {}
  [[nodiscard]] fs::path locate(const std::string& path) const override {
    return scene::checked_path(path) == name_ ? edited_ : folder_.locate(path);
  }
  [[nodiscard]] std::string shown(const std::string& path) const override {
    return folder_.shown(path);
  }

 private:
  scene::FolderFiles folder_;
  std::string name_;
  fs::path edited_;
};

/// An edited scene's text is not the file's, so its lines and columns would mislead.
[[noreturn]] void fail_with(const Error& error, const std::string& values, bool edited) {
  Place place = error.place();
  if (edited) place.line = place.column = 0;
  throw Error(error.kind(), fmt::format("{} (with {})", error.message(), values), place);
}

/// The scene file's JSON with the edits made.
std::string edited_text(const Json& original, const std::vector<SceneEdit>& edits) {
  Json scene = original;
  apply(scene, edits);
  return scene.dump();
}

class Preparer {
 public:
  explicit Preparer(const WedgePlan& plan) : plan_(plan) { out_.jobs.resize(plan.cells.size()); }

  PreparedWedge prepare() {
    const bool edits = std::any_of(plan_.scenes.begin(), plan_.scenes.end(),
                                   [](const auto& edited) { return !edited.empty(); });
    const fs::path& file = plan_.cells.front().job.scene;
    Json original;
    if (edits) {
      load_named_scene(scene::FolderFiles(file.parent_path()), file.filename().string());
      original = parse_json(read_text_file(file, limits::scene_json_bytes), file.string());
    }
    for (std::size_t i = 0; i < plan_.scenes.size(); ++i) {
      if (plan_.scenes[i].empty()) {
        take(i, scene::FolderFiles(file.parent_path()));
      } else {
        out_.edited.emplace_back(edited_text(original, plan_.scenes[i]));
        take(i, EditedFiles(file, out_.edited.back().path()));
      }
    }
    return std::move(out_);
  }

 private:
  void take(std::size_t index, const scene::SceneFiles& files) {
    const fs::path& file = plan_.cells.front().job.scene;
    scene::LoadedScene loaded = [&] {
      try {
        return load_named_scene(files, file.filename().string());
      } catch (const Error& error) {
        if (plan_.scenes[index].empty()) throw;
        std::string values;
        for (const SceneEdit& edit : plan_.scenes[index])
          values +=
              fmt::format("{}{}={}", values.empty() ? "" : " ", edit.path, value_text(edit.value));
        fail_with(error, values, true);
      }
    }();
    if (index == 0)
      out_.scene_name = loaded.scene.name.empty() ? file.stem().string() : loaded.scene.name;
    for (std::string& warning : loaded.warnings)
      if (std::find(out_.warnings.begin(), out_.warnings.end(), warning) == out_.warnings.end())
        out_.warnings.push_back(std::move(warning));
    specify(index, loaded.scene);
    out_.scenes.push_back(assets_of(std::move(loaded.files), hasher_));
    for (std::size_t i = 0; i < plan_.cells.size(); ++i)
      if (plan_.cells[i].scene == index) out_.jobs[i].bundle = out_.scenes.back().digest;
  }

  /// The jobs of one scene.
  void specify(std::size_t index, const scene::Scene& scene) {
    for (std::size_t i = 0; i < plan_.cells.size(); ++i) {
      const WedgeCell& cell = plan_.cells[i];
      if (cell.scene != index) continue;
      try {
        JobSpec spec = job_from(scene, cell.job, Digest{});
        spec.name = excerpt(fmt::format("{} {}", spec.name, text_of(plan_, cell)), 128);
        out_.jobs[i] = std::move(spec);
      } catch (const Error& error) {
        fail_with(error, text_of(plan_, cell), false);
      }
    }
  }

  const WedgePlan& plan_;
  FileHasher hasher_;
  PreparedWedge out_;
};

}  // namespace

PreparedWedge prepare_wedge(const WedgePlan& plan) { return Preparer(plan).prepare(); }

}  // namespace tessera::client
