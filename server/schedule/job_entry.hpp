#pragma once
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>

#include "common/base/clock.hpp"
#include "common/base/digest.hpp"
#include "server/schedule/blame.hpp"
#include "server/schedule/meter.hpp"
#include "server/schedule/task_table.hpp"
#include "server/schedule/tasks_out.hpp"
#include "server/schedule/views.hpp"
#include "server/schedule/work_left.hpp"

namespace tessera::server {

/// A job as the scheduler knows it.
struct JobEntry {
  JobEntry(JobId number, std::shared_ptr<const JobPlan> plan, std::uint32_t passes_ahead)
      : id(number),
        priority(plan->spec.priority),
        max_workers(plan->spec.max_workers),
        left(*plan),
        tasks(std::move(plan), passes_ahead) {}

  enum class State { open, paused, done, failed, cancelled };

  JobId id;
  State state = State::open;
  int priority;
  int max_workers;  // 0: no limit
  WorkLeft left;
  TaskTable tasks;
  BlameTable blame;
  std::optional<Digest> build;  // of its first worker
  std::set<Digest> earlier_plans;
  bool granted = false;  // a lease, ever
  std::string error;

  TasksOut out;  // what is leased
  // Looked up, never walked through: its order is not determined.
  std::unordered_map<TaskId, LeaseId> journaling;

  std::set<std::string> without_files;  // identities that cannot read what it names by path
  std::string without_files_reason;     // the last
  std::set<std::string> unable;  // identities that could not prepare it and are not asked again
  std::set<std::string> unable_names;  // of workers that could not, since a worker was ready
  int unable_times = 0;                // … how often
  std::string unable_reason;           // the last

  std::set<std::string> lost_preparing;  // identities, since a worker was ready
  Instant last_lost_preparing = Instant::min();

  /// Thread-seconds granted, by estimate, over the job's weight: what fairness keeps equal.
  double served = 0;
  std::map<WorkerId, int> at;      // who holds leases of it, and how many
  Meter pace;                      // samples a thread-second
  double preparation_seconds = 0;  // from a worker's first lease to its ready, smoothed
  Meter progress;                  // samples a second, all workers
  Instant progress_mark{};         // up to where `progress` has been told
  Instant begun{};                 // its first lease, in this epoch
  std::optional<Instant> started;  // … ever
  /// Passes after which a frame's noise was, last, asked for and found too high.
  struct Look {
    std::uint32_t asked = 0, too_high = 0;
  };
  std::map<std::int32_t, Look> looks;  // of frames that are not finished
  double changes = 0, losses = 0;      // as Pace says

  [[nodiscard]] const JobPlan& plan() const { return tasks.plan(); }
  /// Of a job whose time is limited: it has one frame.
  [[nodiscard]] std::int32_t only_frame() const { return plan().spec.frames.first(); }
  [[nodiscard]] bool limited() const { return plan().spec.time_limit_seconds > 0; }
  /// Its frames end when their noise is low enough.
  [[nodiscard]] bool watched() const { return plan().spec.noise_threshold > 0; }
  /// Seconds until its time is up; less than 0 after.
  [[nodiscard]] double time_left(Instant now) const {
    return plan().spec.time_limit_seconds - (started ? seconds(now - *started) : 0);
  }
  /// Not ended: results are taken.
  [[nodiscard]] bool live() const { return state == State::open || state == State::paused; }
  /// Of what all workers do, a job gets the part that is its weight among the weights of all that
  /// have work: 2^(priority / 5), so that five steps of priority double it.
  [[nodiscard]] double weight() const { return std::exp2(priority / 5.0); }
  /// No other worker may be given leases of it.
  [[nodiscard]] bool full() const {
    return max_workers > 0 && at.size() >= static_cast<std::size_t>(max_workers);
  }
  /// Those that hold leases of it already go on, unless there are more of them than may be.
  [[nodiscard]] bool has_place_for(WorkerId worker) const {
    return !full() || (at.size() <= static_cast<std::size_t>(max_workers) && at.contains(worker));
  }
  /// It has something to hand out, to whom it may.
  [[nodiscard]] bool has_work() { return !full() && has_open(); }
  [[nodiscard]] bool has_open() {
    return state == State::open && (!blame.waiting().empty() || tasks.peek().has_value());
  }
  [[nodiscard]] bool takes(const Digest& worker_build) const {
    return plan().spec.mixed || !build || *build == worker_build;
  }
  /// A worker was ready so long after its first lease.
  void prepared_in(double took) {
    lost_preparing.clear();
    unable_names.clear();
    unable_times = 0;
    preparation_seconds =
        preparation_seconds == 0 ? took : 0.75 * preparation_seconds + 0.25 * took;
  }
  /// What a task costs in thread-seconds; next to nothing while that is not known.
  [[nodiscard]] double cost(std::int64_t samples) const {
    return static_cast<double>(samples) / (pace.known() ? pace.rate() : 1e6);
  }
};

}  // namespace tessera::server
