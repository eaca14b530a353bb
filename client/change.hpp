#pragma once
#include <functional>
#include <vector>

#include "client/server.hpp"
#include "common/job/task.hpp"

namespace tessera::client {

/// Does `change` to each job, prints the job objects it gives if JSON is asked for, and is done
/// when all were tried: one that fails does not keep the others from their turn. Gives the exit
/// code of the first that failed, else 0.
int change_each(const Settings& settings, const std::vector<JobId>& jobs,
                const std::function<Json(Server&, const std::string& target)>& change);

}  // namespace tessera::client
