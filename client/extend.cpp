#include <nlohmann/json.hpp>

#include "client/change.hpp"
#include "client/commands.hpp"

namespace tessera::client {

int extend(const Settings& settings, const std::vector<JobId>& jobs, std::int64_t samples) {
  return change_each(settings, jobs, [samples](Server& server, const std::string& target) {
    return server.patch(target, Json{{"samples", samples}});
  });
}

}  // namespace tessera::client
