#include <nlohmann/json.hpp>

#include "client/commands.hpp"
#include "client/follow.hpp"
#include "client/print.hpp"

namespace tessera::client {

int wait(const Settings& settings, JobId job) {
  Server server(settings);
  const Json last = follow(server, job, [](const Json&) {});
  if (settings.json) print_json(last);
  return outcome(job_state_from(last));
}

}  // namespace tessera::client
