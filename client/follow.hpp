#pragma once
#include <functional>

#include "client/progress.hpp"
#include "client/server.hpp"

namespace tessera::client {

/// The job as the server has it now.
Json fetch_job(Server& server, JobId job);

/// Follows a job until it has ended, and gives its last object. `changed` is called with each that
/// was seen. Events wake it; where there are none it asks once a second. A server that goes away
/// later is waited for, up to `patience`.
Json follow(Server& server, JobId job, const std::function<void(const Json&)>& changed,
            Duration patience = std::chrono::seconds(60));

/// The exit code of a command whose job ended like this: 0 done, else 1; says why on standard
/// error.
int outcome(const JobState& job);

}  // namespace tessera::client
