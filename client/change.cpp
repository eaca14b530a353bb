#include "client/change.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/print.hpp"
#include "common/base/error.hpp"

namespace tessera::client {

int change_each(const Settings& settings, const std::vector<JobId>& jobs,
                const std::function<Json(Server&, const std::string& target)>& change) {
  Server server(settings);
  int code = 0;
  for (const JobId job : jobs) {
    try {
      const Json answer = change(server, fmt::format("/v1/jobs/{}", job));
      if (settings.json) print_json(answer);
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::unreachable) throw;
      fmt::print(stderr, "tessera: job {}: {}\n", job, error.what());
      if (code == 0) code = exit_code(error.kind());
    }
  }
  return code;
}

}  // namespace tessera::client
