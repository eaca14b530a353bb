#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "client/commands.hpp"
#include "client/prepare.hpp"
#include "client/print.hpp"
#include "client/scene_facts.hpp"

namespace tessera::client {

int info(const Settings& settings, const InfoOptions& options) {
  const NamedScene scene = named_scene(options.scene, options.overrides);
  const SceneFacts facts = facts_of(load_named_scene(scene));
  if (settings.json)
    print_json(to_json(facts));
  else
    fmt::print("{}", text_of(facts));
  return 0;
}

}  // namespace tessera::client
