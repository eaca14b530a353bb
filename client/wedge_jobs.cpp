#include "client/wedge_jobs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "client/preflight.hpp"
#include "common/base/error.hpp"
#include "common/base/files.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"

namespace tessera::client {

namespace fs = std::filesystem;

namespace {

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
    const JobOptions& job = plan_.cells.front().job;
    NamedScene named = named_scene(job.scene, job.overrides);
    Json original;
    if (edits) {
      preflight_.check(survey_named_scene(named));
      original =
          parse_json(named.document.empty() ? read_text_file(job.scene, limits::scene_json_bytes)
                                            : named.document,
                     job.scene.string());
    }
    for (std::size_t i = 0; i < plan_.scenes.size(); ++i) {
      if (plan_.scenes[i].empty()) {
        take(i, named.files, named.path);
      } else {
        out_.edited.emplace_back(edited_text(original, plan_.scenes[i]));
        auto over = named.files.over();
        over[scene::checked_path(named.path)] = {out_.edited.back().path()};
        take(i, OverlayFiles(job.scene.parent_path(), std::move(over)), named.path);
      }
    }
    std::move(named.edited.begin(), named.edited.end(), std::back_inserter(out_.edited));
    return std::move(out_);
  }

 private:
  void take(std::size_t index, const scene::SceneFiles& files, const std::string& path) {
    const fs::path& file = plan_.cells.front().job.scene;
    scene::LoadedScene loaded = [&] {
      try {
        return survey_named_scene(files, path);
      } catch (const Error& error) {
        if (plan_.scenes[index].empty()) throw;
        std::string values;
        for (const SceneEdit& edit : plan_.scenes[index])
          values +=
              fmt::format("{}{}={}", values.empty() ? "" : " ", edit.path, value_text(edit.value));
        fail_with(error, values, true);
      }
    }();
    preflight_.check(loaded);
    if (index == 0)
      out_.scene_name = loaded.scene.name.empty() ? file.stem().string() : loaded.scene.name;
    warn(std::move(loaded.warnings));
    specify(index, loaded.scene);
    out_.scenes.push_back(
        assets_of(std::move(loaded.files), hasher_, by_path_of(plan_.cells.front().job)));
    for (std::size_t i = 0; i < plan_.cells.size(); ++i)
      if (plan_.cells[i].scene == index) out_.jobs[i].bundle = out_.scenes.back().digest;
  }

  /// Of each warning once.
  void warn(std::vector<std::string> warnings) {
    for (std::string& warning : warnings)
      if (std::find(out_.warnings.begin(), out_.warnings.end(), warning) == out_.warnings.end())
        out_.warnings.push_back(std::move(warning));
  }

  /// The jobs of one scene.
  void specify(std::size_t index, const scene::Scene& scene) {
    for (std::size_t i = 0; i < plan_.cells.size(); ++i) {
      const WedgeCell& cell = plan_.cells[i];
      if (cell.scene != index) continue;
      try {
        std::vector<std::string> notes;
        JobSpec spec = job_from(scene, cell.job, Digest{}, &notes);
        warn(std::move(notes));
        spec.name = excerpt(fmt::format("{} {}", spec.name, text_of(plan_, cell)), 128);
        out_.jobs[i] = std::move(spec);
      } catch (const Error& error) {
        fail_with(error, text_of(plan_, cell), false);
      }
    }
  }

  const WedgePlan& plan_;
  FileHasher hasher_;
  Preflight preflight_;
  PreparedWedge out_;
};

}  // namespace

PreparedWedge prepare_wedge(const WedgePlan& plan) { return Preparer(plan).prepare(); }

}  // namespace tessera::client
