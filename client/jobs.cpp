#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "client/commands.hpp"
#include "client/print.hpp"
#include "client/progress.hpp"
#include "client/server.hpp"

namespace tessera::client {

int jobs(const Settings& settings) {
  Server server(settings);
  const Json answer = server.get("/v1/jobs");
  if (settings.json) {
    print_json(answer);
    return 0;
  }
  fmt::print("{:>6}  {:<9}  {:>7}  {:>9}  {}\n", "JOB", "STATE", "DONE", "LEFT", "NAME");
  ObjectReader in(answer, "");
  for (const Json& one : in.required("jobs")) {
    const JobState job = job_state_from(one);
    fmt::print("{:>6}  {:<9}  {:>5.1f} %  {:>9}  {}\n", job.id, job.state, job.progress * 100,
               job.eta_seconds && !job.ended() ? duration_text(*job.eta_seconds) : "", job.name);
  }
  return 0;
}

}  // namespace tessera::client
