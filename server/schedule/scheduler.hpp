#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/base/clock.hpp"
#include "common/base/digest.hpp"
#include "common/job/job_spec.hpp"
#include "common/job/task.hpp"

/// Decides which worker renders what. Sans-IO: events and `now` come in, actions go out; no socket, thread, file or clock.
namespace tessera::server {

using WorkerId = std::uint64_t;

/// What a worker said of itself in its hello.
struct WorkerInfo {
  std::string name;
  std::string identity;
  int threads = 1;
  Digest build_id;
};

// ---- actions, in the order in which they are to be carried out ----
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
};
/// Close the worker's connection: it fell silent, or cheats.
struct DropWorker {
  WorkerId worker = 0;
  std::string reason;
};
/// The job has reached this state; said once.
struct JobFailed {
  JobId job = 0;
  std::string reason;
};
/// Every task of the job is closed and folded.
struct JobFinished {
  JobId job = 0;
};
/// Every task of this frame is closed and folded.
struct FrameFinished {
  JobId job = 0;
  std::int32_t frame = 0;
};
using Action = std::variant<GrantLease, RevokeLeases, DropWorker, JobFailed, JobFinished, FrameFinished>;
using Actions = std::vector<Action>;

/// What to do with a result that has arrived whole, before its tile is decoded.
enum class Verdict {
  take,      ///< open: decode, validate, journal; then result_durable or result_invalid
  stale,     ///< closed already, being journaled already, or the job is gone
  rejected,  ///< never granted to this worker's identity, or not this job's plan
};

struct SchedulerSettings {
  std::uint64_t epoch = 1;                      ///< goes into every lease
  Duration heartbeat = std::chrono::seconds(1); ///< asked of workers
  Duration silence = std::chrono::seconds(4);   ///< nothing heard for so long: lost (work is out again within 5 s)
  int passes_ahead = 3;                         ///< no pass is leased this far or more beyond its tile's fold
  double window_seconds = 1.0;                  ///< work that a worker holds, by its measured speed
  int deaths_alone = 3;                         ///< of a suspect that ran alone: its job fails
  int errors_said = 3;                          ///< by different workers for one task: its job fails
};

/// For the list of workers and for progress; all counts are of the present.
struct WorkerView {
  WorkerId id = 0;
  WorkerInfo info;
  std::string state;                  ///< "idle", "preparing", "rendering", "draining"
  std::size_t leases = 0;
  std::int64_t tasks_done = 0;
  double samples_per_second = 0;      ///< measured, smoothed
  double silent_seconds = 0;
};
struct JobView {
  JobId id = 0;
  std::string state;                  ///< "queued", "rendering", "paused", "done", "failed", "cancelled"
  std::int64_t tasks = 0, tasks_done = 0, leased = 0;
  std::int64_t samples = 0, samples_done = 0;  ///< pixels × samples
  double samples_per_second = 0;      ///< of all its workers at present
  std::optional<double> eta_seconds;
  std::string error;
};

/// One per coordinator. Every function that takes `now` gives back what is to be done because of it; instants never decrease.
/// The cost of a call does not grow with the number of tasks.
class Scheduler {
 public:
  explicit Scheduler(SchedulerSettings settings);
  ~Scheduler();
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  // ---- jobs ----
  /// A new job, or one read back after a start.
  Actions add_job(JobId job, std::shared_ptr<const JobPlan> plan, Instant now);
  /// After a start, before workers join: this task's result is durable (in the journal); not yet folded.
  void restore_closed(JobId job, const TaskId& task);
  /// Its leases are revoked; results that still come are stale. Also how a job that failed elsewhere (disk) is ended.
  Actions cancel_job(JobId job, Instant now);
  Actions fail_job(JobId job, const std::string& reason, Instant now);
  Actions pause_job(JobId job, Instant now);
  Actions resume_job(JobId job, Instant now);
  Actions set_priority(JobId job, int priority, Instant now);
  /// Forgets a job that is done, failed or cancelled.
  void forget_job(JobId job);

  // ---- workers ----
  /// If the identity is still connected, the older connection is dropped. The same identity keeps its id.
  struct Joined {
    WorkerId worker = 0;
    Actions actions;
  };
  Joined worker_joined(const WorkerInfo& info, Instant now);
  /// `clean`: bye, drain or pre-emption, which never count as blame; else its running tasks become suspect.
  Actions worker_left(WorkerId worker, bool clean, Instant now);
  /// Any byte was received.
  void worker_heard(WorkerId worker, Instant now);
  Actions worker_preparing(WorkerId worker, JobId job, Instant now);
  Actions worker_ready(WorkerId worker, JobId job, Instant now);
  Actions worker_progress(WorkerId worker, const std::vector<std::pair<LeaseId, double>>& running, Instant now);
  /// `lease` lacking: the whole job could not be prepared by this worker.
  Actions worker_failed(WorkerId worker, JobId job, std::optional<LeaseId> lease, const std::string& reason, Instant now);
  /// Grants it no more; it finishes what it holds.
  Actions drain_worker(WorkerId worker, Instant now);

  // ---- results ----
  /// Also for leases that have expired or are of an earlier epoch. `identity` is of the worker that sends it. `take` marks
  /// the task as being journaled, so that a second result for it is stale from here on.
  Verdict result_arrived(WorkerId worker, const LeaseId& lease, JobId job, const Digest& plan, const TaskId& task, Instant now);
  /// The tile was not what the task asked for: the task is open again, and it is held against the worker.
  Actions result_invalid(WorkerId worker, const LeaseId& lease, JobId job, const TaskId& task, const std::string& reason, Instant now);
  /// The result is durable: the task is closed. `seconds` and `samples` are what the worker said.
  Actions result_durable(WorkerId worker, const LeaseId& lease, JobId job, const TaskId& task, std::int64_t samples,
                         double seconds, Instant now);
  /// Passes [0, passes) of the tile are folded into its film.
  Actions tile_folded(JobId job, std::int32_t frame, std::uint32_t tile, std::uint32_t passes, Instant now);

  // ---- time ----
  /// What has become due: silent workers, expired leases, windows with room. Call at or after next_deadline().
  Actions tick(Instant now);
  [[nodiscard]] std::optional<Instant> next_deadline() const;

  // ---- looking ----
  [[nodiscard]] std::vector<WorkerView> workers(Instant now) const;
  [[nodiscard]] std::optional<JobView> job(JobId job, Instant now) const;
  [[nodiscard]] std::vector<JobView> jobs(Instant now) const;
  /// True if the lease was granted to this identity; after a restart the store's record of grants has been given back by
  /// restore_grant.
  void restore_grant(JobId job, const TaskId& task, const std::string& identity);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tessera::server
