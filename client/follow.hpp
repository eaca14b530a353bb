#pragma once
#include <functional>
#include <vector>

#include "client/progress.hpp"
#include "client/server.hpp"

namespace tessera::client {

/// The job as the server has it now.
Json fetch_job(Server& server, JobId job);

/// How jobs are followed.
struct Following {
  /// Between two questions: events wake it, but never sooner than `least`; without events it asks
  /// after `most`.
  Duration least = std::chrono::milliseconds(200);
  Duration most = std::chrono::seconds(1);
  /// So long a server that went away is waited for.
  Duration patience = std::chrono::seconds(60);
  /// Called between two rounds of questions; what it throws ends the following.
  std::function<void()> check = [] {};
};

/// Follows jobs until all have ended. `changed` is called with each object that was seen, and which
/// of the jobs it is.
void follow(Server& server, const std::vector<JobId>& jobs,
            const std::function<void(std::size_t index, const Json& job)>& changed,
            const Following& how = {});

/// Follows one job until it has ended, and gives its last object.
Json follow(Server& server, JobId job, const std::function<void(const Json&)>& changed,
            const Following& how = {});

/// "job 3 failed: why", "job 3 was cancelled".
std::string end_text(const JobState& job);
/// The exit code of a command whose job ended like this: 0 done, else 1; says why on standard
/// error.
int outcome(const JobState& job);

}  // namespace tessera::client
