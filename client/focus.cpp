#include <nlohmann/json.hpp>

#include "client/change.hpp"
#include "client/commands.hpp"

namespace tessera::client {

int focus(const Settings& settings, JobId job, const std::optional<Rect>& region) {
  return change_each(settings, {job}, [&](Server& server, const std::string& target) {
    return server.patch(target, Json{{"focus", region ? to_json(*region) : Json()}});
  });
}

}  // namespace tessera::client
