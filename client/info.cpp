#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "client/commands.hpp"
#include "client/prepare.hpp"
#include "client/print.hpp"
#include "client/scene_facts.hpp"

namespace tessera::client {

int info(const Settings& settings, const std::filesystem::path& scene) {
  const scene::FolderFiles files(scene.parent_path());
  const SceneFacts facts = facts_of(load_named_scene(files, scene.filename().string()));
  if (settings.json)
    print_json(to_json(facts));
  else
    fmt::print("{}", text_of(facts));
  return 0;
}

}  // namespace tessera::client
