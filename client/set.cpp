#include <nlohmann/json.hpp>

#include "client/change.hpp"
#include "client/commands.hpp"
#include "common/base/error.hpp"

namespace tessera::client {

int set(const Settings& settings, const SetOptions& options) {
  Json change = Json::object();
  if (options.priority) change["priority"] = *options.priority;
  if (options.max_workers) change["max_workers"] = *options.max_workers;
  if (change.empty())
    throw Error(ErrorKind::bad_input, "expected --priority, --max-workers or both, found neither");
  return change_each(settings, options.jobs, [&](Server& server, const std::string& target) {
    return server.patch(target, change);
  });
}

}  // namespace tessera::client
