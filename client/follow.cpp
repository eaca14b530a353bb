#include "client/follow.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"

namespace tessera::client {

namespace {
constexpr std::chrono::milliseconds least{200};  // between two questions, however many events come
constexpr std::chrono::seconds most{1};
constexpr std::chrono::seconds stream_again{5};  // after a stream broke
}  // namespace

Json fetch_job(Server& server, JobId job) { return server.get(fmt::format("/v1/jobs/{}", job)); }

Json follow(Server& server, JobId job, const std::function<void(const Json&)>& changed,
            Duration patience) {
  using Clock = std::chrono::steady_clock;
  bool seen = false;
  auto last_seen = Clock::now();
  auto last_stream = Clock::now() - stream_again;
  for (;;) {
    try {
      Json object = fetch_job(server, job);
      seen = true;
      last_seen = Clock::now();
      changed(object);
      if (job_state_from(object).ended()) return object;
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::unreachable || !seen || Clock::now() - last_seen > patience)
        throw;
    }
    if (!server.listening() && Clock::now() - last_stream >= stream_again) {
      last_stream = Clock::now();
      server.listen(fmt::format("/v1/jobs/{}/events", job));
    }
    server.pause(least, most);
  }
}

int outcome(const JobState& job) {
  if (job.state == "done") return 0;
  if (job.state == "cancelled")
    fmt::print(stderr, "tessera: job {} was cancelled\n", job.id);
  else
    fmt::print(stderr, "tessera: job {} failed: {}\n", job.id,
               job.error.empty() ? "no reason was given" : job.error);
  return 1;
}

}  // namespace tessera::client
