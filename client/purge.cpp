#include <nlohmann/json.hpp>

#include "client/change.hpp"
#include "client/commands.hpp"

namespace tessera::client {

int purge(const Settings& settings, const std::vector<JobId>& jobs) {
  return change_each(settings, jobs, [](Server& server, const std::string& target) {
    return server.remove(target + "?purge=true");
  });
}

}  // namespace tessera::client
