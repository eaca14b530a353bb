#pragma once
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "common/job/task.hpp"

/// What the scheduler wants done.
namespace tessera::server {

/// One connection of a worker. See Scheduler::worker_joined.
using WorkerId = std::uint64_t;

/// Send this lease to this worker.
struct GrantLease {
  WorkerId worker = 0;
  LeaseId lease;
  JobId job = 0;
  TaskId task;
};
/// Tell the worker to stop these leases; they count no longer.
struct RevokeLeases {
  WorkerId worker = 0;
  std::vector<LeaseId> leases;
  std::string reason;
  bool expired = false;  ///< for want of progress
};
/// Close the worker's connection: it fell silent, came again on another one, or cheats. Its leases
/// are out again already; worker_left is still to be said when the connection has ended.
struct DropWorker {
  WorkerId worker = 0;
  std::string reason;
};
/// The job has failed; said once. Its leases are revoked.
struct JobFailed {
  JobId job = 0;
  std::string reason;
};
/// Every task of the job is closed and folded; said once.
struct JobFinished {
  JobId job = 0;
};
/// Every task of this frame is closed and folded; said once.
struct FrameFinished {
  JobId job = 0;
  std::int32_t frame = 0;
};
using Action =
    std::variant<GrantLease, RevokeLeases, DropWorker, JobFailed, JobFinished, FrameFinished>;
/// In the order in which they are to be carried out.
using Actions = std::vector<Action>;

}  // namespace tessera::server
