#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/clock.hpp"
#include "common/base/digest.hpp"
#include "common/job/job_spec.hpp"
#include "common/job/task.hpp"
#include "server/schedule/actions.hpp"
#include "server/schedule/views.hpp"

/// Decides which worker renders what. Sans-IO: events and `now` come in, actions go out; no socket,
/// thread, file or clock.
namespace tessera::server {

/// What to do with a result that has arrived whole, before its tile is decoded.
enum class Verdict {
  take,      ///< open: decode, validate, journal; then result_durable or result_invalid
  stale,     ///< closed already, being journaled already, or the job is gone
  rejected,  ///< never granted to this worker's identity, or not this job's plan
};

struct SchedulerSettings {
  std::uint64_t epoch = 1;  ///< goes into every lease
  /// Secret of the data folder, the same in every epoch (Store::grant_key): a lease's number proves
  /// with it that the lease was granted, for this task, to this identity. So no grant need be
  /// remembered, neither here nor on disk.
  std::array<std::uint8_t, 16> grant_key{};
  Duration heartbeat = std::chrono::seconds(1);  ///< asked of workers
  Duration silence =
      std::chrono::seconds(4);  ///< nothing heard for so long: lost (work is out again within 5 s)
  /// A lease that runs and gets no further for twenty times as long as it should take in all, but
  /// no less and no more than this, expires; where the worker was not measured, after the most.
  Duration stall_least = std::chrono::seconds(30), stall = std::chrono::minutes(5);
  /// A preparation whose fraction has not grown for so long has failed, though its worker says that
  /// it goes on: scenes may be large and networks slow, but not for ever.
  Duration preparation = std::chrono::minutes(30);
  int passes_ahead = 3;  ///< no pass is leased this far or more beyond its tile's fold; 1 … 32
  double window_seconds = 1.0;  ///< work that a worker holds, by its measured speed
  int window_tasks_least = 2;   ///< … but so many tasks, that it never waits for the network
  int window_tasks_most = 1024;
  /// Leases of one task at once, at the tail: where nothing is open, workers that would idle are
  /// given copies of tasks whose end is expected later than theirs would be. 1: none.
  int copies_most = 3;
  int deaths_alone = 3;  ///< of a suspect that ran alone: its job fails
  int errors_said = 3;   ///< by different workers for one task: its job fails
  int offences = 3;  ///< results rejected or invalid: the worker is dropped, and granted no more
  /// Jobs of which a worker failed on tasks since its last good result, while others render them:
  /// it is granted no more.
  int jobs_failed = 2;
};

/// One per coordinator. Every function that takes `now` gives back what is to be done because of
/// it; instants never decrease. The cost of a call does not grow with the number of tasks. Ids that
/// are not known (any more) are ignored everywhere.
class Scheduler {
 public:
  explicit Scheduler(SchedulerSettings settings);
  ~Scheduler();
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  // ---- jobs ----
  /// A new job, or one read back after a start. `earlier`: digests of plans that it had before it
  /// was extended; results of these are stale and nobody's fault.
  Actions add_job(JobId job, std::shared_ptr<const JobPlan> plan, Instant now,
                  const std::vector<Digest>& earlier = {});
  /// The same for a job that is read back while workers are here: paused, so that nothing is handed
  /// out before restore_closed and tile_folded have said what there is. What was known of it is
  /// forgotten; its leases are revoked. Then resume_job.
  Actions replace_job(JobId job, std::shared_ptr<const JobPlan> plan, Instant now,
                      const std::vector<Digest>& earlier);
  /// After a start, before workers join: this task's result is durable (in the journal); not yet
  /// folded. A tile's passes come in ascending order. Then tile_folded as the film is read back.
  void restore_closed(JobId job, const TaskId& task);
  /// After a start, before anything is said of this frame: it ended by its noise with so many
  /// samples of each pixel, where a pass before the last ends. Of a job of several frames. False,
  /// and nothing is taken, of another number of samples, a frame that is none, or one said twice.
  [[nodiscard]] bool restore_shortened(JobId job, std::int32_t frame, std::int64_t samples);
  /// After a start: the build that made the job's results so far.
  void restore_build(JobId job, const Digest& build);
  /// After a start: when the job's first lease was granted, from which its time limit counts.
  void restore_started(JobId job, Instant first_lease);
  /// Its leases are revoked; results that still come are stale. Also how a job that failed
  /// elsewhere (disk) is ended.
  Actions cancel_job(JobId job, Instant now);
  Actions fail_job(JobId job, const std::string& reason, Instant now);
  /// A paused job is granted no more; what is out comes in.
  Actions pause_job(JobId job, Instant now);
  Actions resume_job(JobId job, Instant now);
  /// The plan's priority counts until this is called.
  Actions set_priority(JobId job, int priority, Instant now);
  /// So do its most of workers and its focus. Where more workers hold leases of it than it may
  /// have, those finish what they hold.
  Actions set_max_workers(JobId job, int max_workers, Instant now);
  /// `focus` lies within the film. O(tiles log tiles).
  Actions set_focus(JobId job, const std::optional<Rect>& focus, Instant now);
  /// Forgets a job that is done, failed or cancelled.
  void forget_job(JobId job);

  // ---- workers ----
  /// The same identity keeps its id when it comes back after worker_left, if it is not long gone.
  /// If its earlier connection has not ended yet, that one is dropped (DropWorker with the old id)
  /// and the new one gets a new id: a late worker_left of the old one cannot be mistaken.
  struct Joined {
    WorkerId worker = 0;
    Actions actions;
  };
  Joined worker_joined(const WorkerInfo& info, Instant now);
  /// `clean`: bye, drain or pre-emption, which never count as blame; else its running tasks become
  /// suspect.
  Actions worker_left(WorkerId worker, bool clean, Instant now);
  /// Any byte was received.
  void worker_heard(WorkerId worker, Instant now);
  /// Nothing was taken in from it up to now, for no fault of its own: this process stood still, or
  /// nothing was read for want of room. What it said meanwhile is still to be read, so all its
  /// clocks begin now: silence, what it runs, and its preparation.
  void excuse_worker(WorkerId worker, Instant now);
  /// `fraction`: how far it is, 0…1.
  Actions worker_preparing(WorkerId worker, JobId job, double fraction, Instant now);
  Actions worker_ready(WorkerId worker, JobId job, Instant now);
  /// What of its leases it runs. After leases have expired the worker is granted nothing until this
  /// names none of them, or a result comes.
  Actions worker_progress(WorkerId worker, const std::vector<std::pair<LeaseId, double>>& running,
                          Instant now);
  /// `lease` lacking: the whole job could not be prepared by this worker; all its leases of the job
  /// are given back.
  Actions worker_failed(WorkerId worker, JobId job, std::optional<LeaseId> lease,
                        const std::string& reason, Instant now);
  /// The job names files by path that this worker cannot read: its leases of it are given back, and
  /// it is granted none until it comes back as another process. Nothing is held against the job.
  Actions worker_lacks_files(WorkerId worker, JobId job, const std::string& reason, Instant now);
  /// Grants it no more; it finishes what it holds, and leaves.
  Actions drain_worker(WorkerId worker, Instant now);
  /// Grants workers of this name no more, those too that come later, until they are released; the
  /// leases that they hold are revoked, and are nobody's fault. Also after a start, before workers
  /// join.
  Actions quarantine(const std::string& name, const std::string& reason, Instant now);
  /// Whatever they were quarantined for is forgotten.
  Actions release(const std::string& name, Instant now);

  // ---- results ----
  /// Also for leases that have expired or are of an earlier epoch. `take` marks the task as being
  /// journaled, so that a second result for it is stale from here on. The worker's window has room
  /// again: tick, or result_durable, fills it.
  Verdict result_arrived(WorkerId worker, const LeaseId& lease, JobId job, const Digest& plan,
                         const TaskId& task, Instant now);
  /// The tile was not what the task asked for: the task is open again, and it is held against the
  /// worker. Also, with an empty `reason`, when the result could not be kept for no fault of the
  /// worker's (a full disk): then nothing is held against it.
  Actions result_invalid(WorkerId worker, const LeaseId& lease, JobId job, const TaskId& task,
                         const std::string& reason, Instant now);
  /// The result is durable: the task is closed. `seconds` and `samples` are what the worker said.
  Actions result_durable(WorkerId worker, const LeaseId& lease, JobId job, const TaskId& task,
                         std::int64_t samples, double seconds, Instant now);
  /// Passes [0, passes) of the tile are folded into its film.
  Actions tile_folded(JobId job, std::int32_t frame, std::uint32_t tile, std::uint32_t passes,
                      Instant now);
  /// The answer to MeasureNoise: by server/film/noise.hpp.
  Actions noise_measured(JobId job, std::int32_t frame, std::uint32_t passes, double noise,
                         Instant now);

  // ---- time ----
  /// What has become due: silent workers, expired leases, windows with room. Call at or after
  /// next_deadline().
  Actions tick(Instant now);
  [[nodiscard]] std::optional<Instant> next_deadline() const;

  // ---- looking ----
  [[nodiscard]] std::vector<WorkerView> workers(Instant now) const;
  [[nodiscard]] std::optional<JobView> job(JobId job, Instant now) const;
  [[nodiscard]] std::vector<JobView> jobs(Instant now) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tessera::server
