#include <nlohmann/json.hpp>

#include "client/change_worker.hpp"
#include "client/commands.hpp"
#include "common/net/http_client.hpp"

namespace tessera::client {

int quarantine(const Settings& settings, const QuarantineOptions& options) {
  Json body = Json::object();
  if (!options.reason.empty()) body["reason"] = options.reason;
  return change_names(settings, options.workers, Absent::any,
                      [&](Server& server, const std::string& name) {
                        return server.put("/v1/quarantines/" + net::url_encoded(name), body);
                      });
}

}  // namespace tessera::client
