#include <nlohmann/json.hpp>

#include "client/change_worker.hpp"
#include "client/commands.hpp"

namespace tessera::client {

int release(const Settings& settings, const std::vector<std::string>& workers) {
  return change_workers(settings, workers, Json{{"state", "idle"}});
}

}  // namespace tessera::client
