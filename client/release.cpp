#include <nlohmann/json.hpp>

#include "client/change_worker.hpp"
#include "client/commands.hpp"
#include "common/net/http_client.hpp"

namespace tessera::client {

int release(const Settings& settings, const std::vector<std::string>& workers) {
  return change_names(settings, workers, Absent::quarantined,
                      [](Server& server, const std::string& name) {
                        return server.remove("/v1/quarantines/" + net::url_encoded(name));
                      });
}

}  // namespace tessera::client
