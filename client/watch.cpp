#include <nlohmann/json.hpp>

#include "client/commands.hpp"
#include "client/follow.hpp"
#include "client/print.hpp"

namespace tessera::client {

int watch(const Settings& settings, JobId job) {
  Server server(settings);
  ProgressPrinter printer(1);
  const Json last = follow(server, job, [&](const Json& object) {
    if (settings.json)
      print_json(object);
    else
      printer.show(job_state_from(object));
  });
  printer.finish();
  return outcome(job_state_from(last));
}

}  // namespace tessera::client
