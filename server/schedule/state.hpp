#pragma once
#include <fmt/format.h>

#include <deque>
#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "server/schedule/finish.hpp"
#include "server/schedule/job_entry.hpp"
#include "server/schedule/lease_numbers.hpp"
#include "server/schedule/scheduler.hpp"
#include "server/schedule/timers.hpp"
#include "server/schedule/worker_entry.hpp"

namespace tessera::server {

/// All that the scheduler knows, and the steps that its events are made of. Steps add to `actions`;
/// `settle` comes last.
struct Scheduler::State {
  explicit State(const SchedulerSettings& chosen)
      : settings(chosen), numbers(chosen.epoch, chosen.grant_key) {}

  SchedulerSettings settings;
  LeaseNumbers numbers;
  std::map<JobId, JobEntry> jobs;
  std::vector<JobEntry*> order;  // jobs not ended: by priority, then by id
  std::set<JobId> limited;       // of those, the ones with a time limit
  std::map<WorkerId, WorkerEntry> workers;

  /// A worker process, also while it is away.
  struct Identity {
    WorkerId worker = 0;
    bool connected = false;  // worker_left of its last connection has not been said
    std::uint64_t left = 0;  // its place among those that have gone
    int offences = 0;
    std::map<JobId, std::string> failures;  // of tasks, since its last good result: what it said
  };
  // Looked up, never walked through.
  std::unordered_map<std::string, Identity> identities;
  /// Those that have gone and are known still, at most so many; the first to be forgotten in front.
  /// Some have come back since.
  static constexpr std::size_t away_most = 16384;
  std::deque<std::pair<std::uint64_t, std::string>> away;
  std::uint64_t last_left = 0;
  /// Why workers of this name are granted nothing. A machine's fault outlives its processes.
  std::map<std::string, std::string> quarantines;
  std::unordered_map<WorkerId, std::string>
      dropped;  // connections that were told to end and have not yet
  /// Scenes whose preparation a worker did not survive, as far as is known: (bundle, name) to the
  /// identities that have not come back. A worker that is started again has a new identity. Of
  /// scenes that a job uses.
  std::map<std::pair<Digest, std::string>, std::set<std::string>> crashed;
  WorkerId last_worker = 0;
  /// The most `served` that a job had as it was granted a task: never less than before.
  double virtual_time = 0;
  struct Power {
    double power = 0;
    double left = 0;  ///< work of the job that is expected to be done yet
  };
  /// powers_of_all, as it was at some instant.
  mutable std::optional<std::pair<Instant, std::map<JobId, Power>>> powers;

  Timers timers;
  std::set<WorkerId> touched;    // whose window may have room
  std::set<WorkerId> reserving;  // workers with a suspect reserved
  bool work_appeared = false;    // for workers that found none before
  /// Workers with room for which there was no work, by build.
  std::map<Digest, std::set<WorkerId>> hungry;
  std::set<WorkerId> idlers;         // of those, the ones that hold nothing at all
  std::optional<Instant> tail_look;  // when they are to be asked again
  WorkerId last_asked = 0;
  Instant last_now{};

  // ---- looking up (nullptr: not known) ----
  JobEntry* job(JobId id);
  JobEntry* live_job(JobId id);
  WorkerEntry* worker(WorkerId id);
  /// Those that are here, by id. O(workers).
  std::vector<WorkerEntry*> named(const std::string& name);

  // ---- grants.cpp: what goes out ----
  /// It can prepare the job, as far as is known.
  [[nodiscard]] bool able(const JobEntry& job, const WorkerEntry& worker) const;
  [[nodiscard]] bool eligible(const JobEntry& job, const WorkerEntry& worker) const;
  /// True if a connected worker that does not stand still and is not among `but`, by identity, may
  /// take the job; nor among `names`.
  [[nodiscard]] bool anyone_else(const JobEntry& job, const std::set<std::string>& but,
                                 const std::set<std::string>& names = {}) const;
  /// It was lost with the task, or failed on it, and another is there to ask.
  [[nodiscard]] bool for_another(const JobEntry& job, const TaskId& task,
                                 const WorkerEntry& worker) const;
  [[nodiscard]] const TaskId* suspect_for(const JobEntry& job, const WorkerEntry& worker) const;
  JobEntry* pick(const WorkerEntry& worker);
  void grant(WorkerEntry& worker, JobEntry& job, const TaskId& task, bool alone, Instant now,
             Actions& actions);
  /// The suspect that a busy worker was to run next, for one that has nothing at all.
  bool take_over(WorkerEntry& idle, Instant now, Actions& actions);
  bool grant_one(WorkerEntry& worker, Instant now, Actions& actions);
  void fill(WorkerEntry& worker, Instant now, Actions& actions);
  void serve_hungry(Instant now, Actions& actions);
  /// Fills windows with room: the last step of every event.
  void settle(Instant now, Actions& actions);

  // ---- tail.cpp: copies of late tasks ----
  /// Samples a second, also by what its running leases say; by other workers if nothing is known.
  [[nodiscard]] double speed_of(const WorkerEntry& worker, const JobEntry& job) const;
  /// When this attempt is expected to be done: after `now`, or TasksOut::unknown.
  Instant expected_end(const JobEntry& job, const Holder& holder, Instant now);
  /// … the first of the task's attempts.
  Instant expected_end(const JobEntry& job, const TaskId& task, Instant now);
  bool worth_a_copy(const JobEntry& job, const TaskId& task, Instant end, const WorkerEntry& idle,
                    Instant now);
  /// The task of the job that a copy in this worker's hands would help most.
  std::optional<TaskId> late_task(JobEntry& job, const WorkerEntry& idle, Instant now);
  bool grant_copy(WorkerEntry& idle, Instant now, Actions& actions);
  /// Asks idle workers in turn: what was to come in time may have become late.
  void look_at_tail(Instant now, Actions& actions);
  void plan_tail_look(Instant now);

  // ---- results.cpp ----
  /// Says what a fold has finished.
  void finished(JobEntry& job, std::int32_t frame, TaskTable::Folded what, Actions& actions);
  /// The task is closed: whoever else holds it may stop.
  void stop_others(JobEntry& job, const TaskId& task, Instant now, Actions& actions);

  // ---- leases.cpp: what comes back without a result ----
  /// The lease is over; its task stays taken, and is the caller's to put back or close.
  HeldLease end_lease(WorkerEntry& worker, std::uint64_t number);
  /// Taken, and its result has not come: what a worker says against it counts.
  [[nodiscard]] bool is_awaited(const JobEntry& job, const TaskId& task) const;
  /// … and not leased either.
  [[nodiscard]] bool is_aside(const JobEntry& job, const TaskId& task) const;
  /// A task that is aside is opened again, or waits as a suspect.
  void put_back(JobEntry& job, const TaskId& task);
  void set_aside(JobEntry& job, const TaskId& task);
  void clear_reservation(WorkerEntry& worker);
  /// … and the suspect waits for another.
  void unreserve(WorkerEntry& worker);
  void lost_while_running(JobEntry& job, const TaskId& task, const WorkerInfo& lost, bool alone,
                          Actions& actions);
  /// What a worker is charged with.
  struct Charge {
    AttemptFailed::Outcome outcome = AttemptFailed::Outcome::lost;
    std::string reason;
  };
  /// What it ran is held against it, if there is a charge.
  void give_back_all(WorkerEntry& worker, const std::optional<Charge>& charge, Actions& actions);
  /// A lease that ends without a result, held against its worker if there is a charge.
  void give_back(WorkerEntry& worker, std::uint64_t number, const std::optional<Charge>& charge,
                 Actions& actions);
  /// Begins the clock of a lease that its worker has begun.
  void begin_running(const WorkerEntry& worker, HeldLease& held, Instant now);
  /// What runs and stands still; all, if nothing was ever said of any.
  void expire(WorkerEntry& worker, Instant now, Actions& actions);
  void error_said(JobEntry& job, const TaskId& task, const std::string& identity,
                  const std::string& reason, Actions& actions);
  /// After an error, ever longer with each in a row: a broken worker does not race through the
  /// tasks.
  void rest(WorkerEntry& worker, Instant now);
  void offend(WorkerEntry& worker);
  /// It failed where others do not: on tasks of different jobs, that bars it.
  void fault_of(WorkerEntry& worker, JobId job, const std::string& reason);
  /// Gives the workers of that name.
  std::vector<WorkerEntry*> bar(const std::string& name, const std::string& reason);

  // ---- preparation.cpp: scenes that could not be built ----
  /// A connected worker has the scene.
  [[nodiscard]] bool anyone_ready(const JobEntry& job) const;
  /// Names of the workers that hold leases and have not built it yet.
  [[nodiscard]] std::size_t names_preparing(const JobEntry& job) const;
  /// The worker was lost while it built this job's scene.
  void lost_while_preparing(JobEntry& job, const WorkerEntry& lost, Instant now, Actions& actions);
  /// Fails the job, if nobody has prepared it: where workers of several names could not, and no
  /// fewer than still try; or all that are here, again and again.
  void judge_preparation(JobEntry& job, const std::string& reason, Actions& actions);
  /// All its leases of the job are given back, and it is not asked again while others are there.
  /// Ends the worker's leases of the job, and its part in it; gives what they were.
  std::vector<HeldLease> end_all(WorkerEntry& worker, const JobEntry& job);
  void lacks_files(WorkerEntry& worker, JobEntry& job, const std::string& reason);
  void could_not_prepare(WorkerEntry& worker, JobEntry& job, const std::string& reason, Instant now,
                         Actions& actions);
  /// Its preparation does not get on.
  void give_up_preparation(WorkerEntry& worker, Instant now, Actions& actions);
  /// It said that it prepares this job, of which it holds nothing; or it has been given up there.
  void hangs(WorkerEntry& worker, JobId job);
  /// … for as long again as a preparation may stand still: as if it had been asked once more.
  void still_hangs(WorkerEntry& worker, Instant now, Actions& actions);

  // ---- pace.cpp ----
  /// What is known of how fast it gets on; nothing while no speed is. O(leases of its workers).
  [[nodiscard]] std::optional<Pace> pace_of(const JobEntry& job, Instant now) const;
  /// Power that all workers would have for a job, as far as any of them was measured at it; by job.
  [[nodiscard]] const std::map<JobId, Power>& powers_of_all(Instant now) const;
  void share_with_others(const JobEntry& job, Instant now, Pace& pace) const;
  /// Who holds leases of it; if nobody does and `or_were`, who has held some. O(workers) then.
  [[nodiscard]] std::vector<const WorkerEntry*> at_work(const JobEntry& job, bool or_were) const;
  /// To the end of so many passes of every tile (a job of one frame). And O(tiles).
  [[nodiscard]] std::optional<Pace> pace_of(const JobEntry& job, std::uint32_t passes,
                                            Instant now) const;
  /// To the end, where a frame has so many passes and `spared` samples of each pixel are not made.
  [[nodiscard]] std::optional<Pace> pace_to(const JobEntry& job, std::uint32_t passes,
                                            double spared, bool or_were, Instant now) const;

  // ---- time_limit.cpp ----
  /// Jobs whose time is limited and that have nothing left to hand out are given another pass, if
  /// it will be over in time for every tile. True if one was.
  bool offer_passes(Instant now, Actions& actions);
  /// Whether the next pass will be over in time; nothing while that cannot be said.
  [[nodiscard]] std::optional<bool> in_time(const JobEntry& job, Instant now) const;
  /// The frame ends with the passes that are offered of it.
  void cut(JobEntry& job, std::int32_t frame, Actions& actions);

  // ---- noise_stop.cpp ----
  /// Passes [0, passes) of each frame are handed out, and where noise alone may end it all up to
  /// the next look; of a job that is new.
  void offer_first(JobEntry& job, std::uint32_t passes);
  /// … of this frame, of which fewer were.
  void offer(JobEntry& job, std::int32_t frame, std::uint32_t passes);
  /// No pass beyond those offered of the frame may be, before its noise is known.
  [[nodiscard]] bool awaits_look(const JobEntry& job, std::int32_t frame) const;
  /// Asks for that, once all is folded.
  void ask_for_look(JobEntry& job, std::int32_t frame, Actions& actions);

  // ---- waiting.cpp ----
  /// Why a job has work and none of it is out; empty if there is no such reason.
  [[nodiscard]] std::string waiting_for(const JobEntry& job) const;

  // ---- jobs.cpp ----
  /// nullptr if there is one already.
  JobEntry* add(JobId job, std::shared_ptr<const JobPlan> plan, Instant now,
                const std::vector<Digest>& earlier);
  void sort_order();
  /// A job that comes, comes back or changes its weight is owed nothing.
  void level(JobEntry& job);
  void end_job(JobEntry& job, JobEntry::State state, const std::string& reason, Actions& actions);
  void fail(JobEntry& job, const std::string& reason, Actions& actions);

  // ---- workers.cpp ----
  /// Its last connection has ended. Of those that went before many others, nothing is kept.
  void went_away(const std::string& identity);
  /// A worker has gone or stands still: what waited for it alone is for the others.
  void count_without();
  void disconnect(WorkerId id, const std::optional<Charge>& charge, Instant now, Actions& actions);
  void drop(WorkerEntry& worker, bool blame, const std::string& reason, Instant now,
            Actions& actions);
};

}  // namespace tessera::server
