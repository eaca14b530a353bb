#include "client/overrides.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/files.hpp"
#include "common/base/json.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"
#include "common/scene/gltf/gltf.hpp"

namespace tessera::client {

namespace fs = std::filesystem;

namespace {

/// Where the environment's picture stands in the scene, whatever its file is called.
constexpr const char* environment_path = "tessera-environment/picture";

[[noreturn]] void fail_at(const char* flag, const std::string& message) {
  throw Error(ErrorKind::bad_input, message, {.file = {}, .key = flag});
}

/// One number, or three with commas between.
std::optional<Json> color_from(std::string_view text) {
  Json out = Json::array();
  while (true) {
    double value = 0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (problem != std::errc()) return std::nullopt;
    out.push_back(value);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (text.empty()) break;
    if (text.front() != ',') return std::nullopt;
    text.remove_prefix(1);
  }
  if (out.size() != 1 && out.size() != 3) return std::nullopt;
  return out.size() == 1 ? Json(out[0]) : out;
}

class Override {
 public:
  Override(const fs::path& scene, const SceneOverrides& overrides)
      : scene_(scene), overrides_(overrides), name_(scene.filename().string()) {}

  NamedScene make() {
    const fs::path folder = scene_.parent_path();
    if (!overrides_.any()) return {OverlayFiles(folder, {}), name_, {}, {}};
    const scene::LoadedScene loaded = survey_named_scene(scene::FolderFiles(folder), name_);
    const bool gltf = scene::gltf::is_gltf(name_);
    Json document =
        gltf ? including(loaded.scene)
             : parse_json(read_text_file(scene_, limits::scene_json_bytes), scene_.string());
    edit_includes(document);
    edit_environment(document, loaded.scene);
    const std::string path = scene::checked_path(gltf ? name_ + ".overridden.json" : name_);
    std::vector<MemoryFile> held;
    std::string text = document.dump();
    held.emplace_back(text);
    over_[path] = {held.front().path()};
    return {OverlayFiles(folder, std::move(over_)), path, std::move(held), std::move(text)};
  }

 private:
  /// A document that shows what the glTF file alone would.
  [[nodiscard]] Json including(const scene::Scene& scene) const {
    return {{"tessera", 1},
            {"film", {{"width", scene.render.width}, {"height", scene.render.height}}},
            {"include", Json::array({Json::object({{"file", name_}})})}};
  }

  void edit_includes(Json& document) const {
    if (!overrides_.variant && !overrides_.units) return;
    const char* const flag = overrides_.variant ? "--variant" : "--units";
    const auto list = document.find("include");
    if (list == document.end() || !list->is_array() || list->empty())
      fail_at(flag, fmt::format("is of glTF files, and {} includes none", scene_.string()));
    for (Json& item : *list) {
      if (item.is_string()) item = Json::object({{"file", item}});
      if (overrides_.variant) item["variant"] = *overrides_.variant;
      if (overrides_.units) item["units"] = *overrides_.units;
    }
  }

  void edit_environment(Json& document, const scene::Scene& scene) {
    const auto& given = overrides_.environment;
    if (!given && !overrides_.environment_strength && !overrides_.environment_rotation) return;
    Json& environment = document["environment"];
    if (given)
      environment = environment_from(*given);
    else if (environment.is_null() && scene.environment)
      environment = Json::object({{"studio", true}});  // what was made up
    else if (environment.is_null())
      fail_at(overrides_.environment_strength ? "--env-strength" : "--env-rotate",
              "the scene has no environment; give it one by --env");
    if (overrides_.environment_strength) environment["strength"] = *overrides_.environment_strength;
    if (overrides_.environment_rotation) environment["rotation"] = *overrides_.environment_rotation;
  }

  Json environment_from(const std::string& text) {
    if (text == "studio") return Json::object({{"studio", true}});
    if (const auto color = color_from(text)) return Json::object({{"radiance", *color}});
    std::error_code error;
    const fs::path file = fs::canonical(text, error);
    if (error || !fs::is_regular_file(file))
      fail_at("--env", fmt::format("no file \"{}\"; expected a picture's file, R,G,B or studio",
                                   excerpt(text, 200)));
    over_[environment_path] = {file, text};
    return Json::object({{"file", environment_path}});
  }

  const fs::path& scene_;
  const SceneOverrides& overrides_;
  std::string name_;
  std::map<std::string, OverlaidFile> over_;
};

}  // namespace

NamedScene named_scene(const fs::path& scene, const SceneOverrides& overrides) {
  return Override(scene, overrides).make();
}

scene::LoadedScene survey_named_scene(const scene::SceneFiles& files, const std::string& path) {
  try {
    return scene::survey_scene(files, path);
  } catch (const Error& error) {
    // A scene that is not there was named wrongly: the command's input, not something that it did,
    // is at fault.
    if (error.kind() == ErrorKind::not_found)
      throw Error(ErrorKind::bad_input, error.message(), error.place());
    throw;
  }
}

scene::LoadedScene survey_named_scene(const NamedScene& scene) {
  const auto told = [&](const Error& error) {
    Place place = error.place();
    if (scene.edited.empty() || place.file != scene.files.shown(scene.path)) return error;
    place.line = place.column = 0;
    return Error(error.kind(), error.message(), place);
  };
  try {
    scene::LoadedScene out = survey_named_scene(scene.files, scene.path);
    for (Error& problem : out.problems) problem = told(problem);
    return out;
  } catch (const Error& error) {
    throw told(error);
  }
}

}  // namespace tessera::client
