#include <nlohmann/json.hpp>

#include "client/change.hpp"
#include "client/commands.hpp"

namespace tessera::client {

int resume(const Settings& settings, const std::vector<JobId>& jobs) {
  return change_each(settings, jobs, [](Server& server, const std::string& target) {
    return server.patch(target, Json{{"state", "rendering"}});
  });
}

}  // namespace tessera::client
