#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "client/commands.hpp"
#include "client/print.hpp"
#include "client/progress.hpp"
#include "client/server.hpp"
#include "client/table.hpp"

namespace tessera::client {

int jobs(const Settings& settings) {
  Server server(settings);
  const Json answer = server.get("/v1/jobs");
  if (settings.json) {
    print_json(answer);
    return 0;
  }
  constexpr auto right = Table::Align::right;
  Table table{{{"JOB", right}, {"STATE"}, {"DONE", right}, {"LEFT", right}, {"NAME"}}, {}};
  ObjectReader in(answer, "");
  for (const Json& one : in.required("jobs")) {
    const JobState job = job_state_from(one);
    table.rows.push_back({std::to_string(job.id), job.state,
                          fmt::format("{:.1f} %", job.progress * 100),
                          job.ended() ? "" : eta_text(job), job.name});
  }
  fmt::print("{}", text_of(table));
  return 0;
}

}  // namespace tessera::client
