#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "client/commands.hpp"
#include "client/print.hpp"
#include "client/progress.hpp"
#include "client/server.hpp"
#include "client/table.hpp"
#include "common/base/error.hpp"
#include "common/base/names.hpp"

namespace tessera::client {

int workers(const Settings& settings) {
  Server server(settings);
  const Json answer = server.get("/v1/workers");
  if (settings.json) {
    print_json(answer);
    return 0;
  }
  constexpr auto right = Table::Align::right;
  Table table{{{"WORKER", right},
               {"STATE"},
               {"THREADS", right},
               {"TASKS", right},
               {"SAMPLES/S", right},
               {"NAME"},
               {"REASON"}},
              {}};
  ObjectReader in(answer, "");
  try {
    std::set<std::string> here;
    for (const Json& worker : in.required("workers")) {
      const auto name = worker.at("name").get<std::string>();
      const Json& reason = worker.at("reason");
      here.insert(name);
      table.rows.push_back({std::to_string(worker.at("id").get<std::uint64_t>()),
                            worker.at("state").get<std::string>(),
                            std::to_string(worker.at("threads").get<int>()),
                            std::to_string(worker.at("tasks_done").get<std::int64_t>()),
                            count_text(worker.at("samples_per_second").get<double>()), name,
                            reason.is_null() ? "" : excerpt(reason.get<std::string>())});
    }
    // Names that are kept from work, and of which no worker is connected.
    for (const Json& one : in.required("quarantines"))
      if (const auto name = one.at("name").get<std::string>(); !here.contains(name))
        table.rows.push_back({"-", "quarantined", "-", "-", "-", name,
                              excerpt(one.at("reason").get<std::string>())});
  } catch (const Json::exception& odd) {
    throw Error(ErrorKind::failed,
                fmt::format("the server's list of workers cannot be read: {}", odd.what()));
  }
  fmt::print("{}", text_of(table));
  return 0;
}

}  // namespace tessera::client
