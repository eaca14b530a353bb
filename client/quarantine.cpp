#include <nlohmann/json.hpp>

#include "client/change_worker.hpp"
#include "client/commands.hpp"

namespace tessera::client {

int quarantine(const Settings& settings, const QuarantineOptions& options) {
  Json body = {{"state", "quarantined"}};
  if (!options.reason.empty()) body["reason"] = options.reason;
  return change_workers(settings, options.workers, body);
}

}  // namespace tessera::client
