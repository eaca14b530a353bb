#include "client/post.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/interrupt.hpp"
#include "common/base/error.hpp"

namespace tessera::client {

Json post_job(Server& server, const JobSpec& spec) {
  throw_if_interrupted();
  const Uninterrupted whole;
  return server.post("/v1/jobs", to_json(spec));
}

void cancel_posted(Server& server, const std::vector<JobId>& jobs) {
  const Uninterrupted ending;
  int cancelled = 0;
  for (const JobId job : jobs) {
    try {
      server.remove(fmt::format("/v1/jobs/{}", job));
      ++cancelled;
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::conflict || error.kind() == ErrorKind::not_found) continue;
      fmt::print(stderr, "tessera: job {} could not be cancelled: {}\n", job, error.what());
      if (error.kind() == ErrorKind::unreachable) break;  // nor could the others
    }
  }
  if (cancelled > 0)
    fmt::print(stderr, "tessera: cancelled {} job{}\n", cancelled, cancelled == 1 ? "" : "s");
}

}  // namespace tessera::client
