#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "client/commands.hpp"
#include "client/overrides.hpp"
#include "client/preflight.hpp"
#include "client/print.hpp"
#include "client/scene_facts.hpp"

namespace tessera::client {

int info(const Settings& settings, const InfoOptions& options) {
  const NamedScene scene = named_scene(options.scene, options.overrides);
  const scene::LoadedScene loaded = survey_named_scene(scene);
  Preflight preflight;
  preflight.check(loaded);
  const SceneFacts facts = facts_of(loaded, preflight.decoded_bytes());
  if (settings.json)
    print_json(to_json(facts));
  else
    fmt::print("{}", text_of(facts));
  return 0;
}

}  // namespace tessera::client
