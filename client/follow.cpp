#include "client/follow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numeric>

#include "common/base/error.hpp"

namespace tessera::client {

namespace {
using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds stream_again{5};  // after a stream broke

/// Asks for each of the jobs in `open`, and takes those out that have ended.
void ask(Server& server, const std::vector<JobId>& jobs, std::vector<std::size_t>& open,
         const std::function<void(std::size_t, const Json&)>& changed) {
  for (auto at = open.begin(); at != open.end();) {
    const Json object = fetch_job(server, jobs[*at]);
    const bool ended = job_state_from(object).ended();
    changed(*at, object);
    at = ended ? open.erase(at) : at + 1;
  }
}
}  // namespace

Json fetch_job(Server& server, JobId job) { return server.get(fmt::format("/v1/jobs/{}", job)); }

void follow(Server& server, const std::vector<JobId>& jobs,
            const std::function<void(std::size_t, const Json&)>& changed, const Following& how) {
  std::vector<std::size_t> open(jobs.size());
  std::iota(open.begin(), open.end(), std::size_t{0});
  const std::string events =
      jobs.size() == 1 ? fmt::format("/v1/jobs/{}/events", jobs.front()) : "/v1/events";
  bool seen = false;
  auto last_seen = Clock::now();
  auto last_stream = Clock::now() - stream_again;
  for (;;) {
    how.check();
    try {
      ask(server, jobs, open, changed);
      seen = true;
      last_seen = Clock::now();
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::unreachable || !seen ||
          Clock::now() - last_seen > how.patience)
        throw;
    }
    if (open.empty()) return;
    if (!server.listening() && Clock::now() - last_stream >= stream_again) {
      last_stream = Clock::now();
      server.listen(events);
    }
    server.pause(how.least, how.most);
  }
}

Json follow(Server& server, JobId job, const std::function<void(const Json&)>& changed,
            const Following& how) {
  Json last;
  follow(
      server, std::vector<JobId>{job},
      [&](std::size_t, const Json& object) {
        last = object;
        changed(object);
      },
      how);
  return last;
}

std::string end_text(const JobState& job) {
  if (job.state == "cancelled") return fmt::format("job {} was cancelled", job.id);
  if (job.state != "failed") return fmt::format("job {} is {}", job.id, job.state);
  return fmt::format("job {} failed: {}", job.id,
                     job.error.empty() ? "no reason was given" : job.error);
}

int outcome(const JobState& job) {
  if (job.state == "done") return 0;
  fmt::print(stderr, "tessera: {}\n", end_text(job));
  return 1;
}

}  // namespace tessera::client
