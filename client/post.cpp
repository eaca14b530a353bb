#include "client/post.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <thread>

#include "client/interrupt.hpp"
#include "common/base/error.hpp"
#include "common/base/random.hpp"

namespace tessera::client {

namespace {
constexpr std::size_t key_bytes = 16;
constexpr Duration retry_first = std::chrono::milliseconds(250);
constexpr Duration retry_most = std::chrono::seconds(2);  // some four seconds in all
}  // namespace

Json post_job(Server& server, const JobSpec& spec) {
  throw_if_interrupted();
  const Uninterrupted whole;
  const Json body = to_json(spec);
  const std::string key = random_hex(key_bytes);
  for (Duration wait = retry_first;; wait *= 2) {
    try {
      return server.post_once("/v1/jobs", body, key);
    } catch (const Error& error) {
      // Whether the server took the job is not known: under the same key it takes no second one.
      if (error.kind() != ErrorKind::unreachable || wait > retry_most) throw;
      fmt::print(stderr, "tessera: {}; trying again\n", error.what());
    }
    std::this_thread::sleep_for(wait);
  }
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
