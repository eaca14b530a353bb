#pragma once
#include <vector>

#include "client/server.hpp"
#include "common/job/job_spec.hpp"

/// Jobs that come to a server, and that are taken back if what posted them does not go on.
namespace tessera::client {

/// Posts a job and gives the job object that the server answers. Where no answer comes it is posted
/// again, under a key by which the server knows it, so that there is one job in any case. A signal
/// that comes meanwhile does not break it off, for the server may have taken the job and its id
/// would be lost: ask interrupted() once the id is kept. Throws Interrupted if one was noted
/// before.
Json post_job(Server& server, const JobSpec& spec);

/// Cancels jobs, each of them as far as it can be, even after a signal; says on standard error how
/// many, and which could not be. One that has ended meanwhile is as it should be.
void cancel_posted(Server& server, const std::vector<JobId>& jobs);

}  // namespace tessera::client
