#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/base/clock.hpp"
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
/// Granted nothing until it is released; said once each time that it connects or is barred.
struct WorkerQuarantined {
  WorkerId worker = 0;
  std::string reason;
};
/// The job has failed; said once. Its leases are revoked.
struct JobFailed {
  JobId job = 0;
  std::string reason;
};
/// The job, which has one frame, is done with so many samples of each pixel, for its time is up or
/// its noise low enough: as if these had been asked for. Said once, just before it is finished.
struct JobShortened {
  JobId job = 0;
  std::int64_t samples = 0;
};
/// One of the job's several frames is done with so many samples of each pixel, for its noise is low
/// enough: as if it were a job of its own of which these had been asked for. Said just before it is
/// finished, once in each epoch.
struct FrameShortened {
  JobId job = 0;
  std::int32_t frame = 0;
  std::int64_t samples = 0;
};
/// The frame has so many passes of every tile, and gets no more before Scheduler::noise_measured
/// says how noisy it is.
struct MeasureNoise {
  JobId job = 0;
  std::int32_t frame = 0;
  std::uint32_t passes = 0;
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
/// An attempt has given no result, for a reason that is held against it. To be kept for people;
/// nothing depends on it.
struct AttemptFailed {
  enum class Outcome {
    lost,     ///< its worker was lost while it ran
    stalled,  ///< it made no progress for too long
    failed,   ///< its worker said an error
    invalid,  ///< its result was not what was asked for
  };
  JobId job = 0;
  std::optional<TaskId> task;  ///< lacking: the job's scene was being prepared
  LeaseId lease;               ///< of the task; 0.0 without one
  WorkerId worker = 0;
  std::string worker_name;
  Outcome outcome = Outcome::lost;
  std::string reason;
  std::optional<Instant> granted;  ///< lacking: no longer known
};
using Action =
    std::variant<GrantLease, RevokeLeases, DropWorker, JobFailed, JobShortened, FrameShortened,
                 JobFinished, FrameFinished, AttemptFailed, WorkerQuarantined, MeasureNoise>;
/// In the order in which they are to be carried out.
using Actions = std::vector<Action>;

}  // namespace tessera::server
