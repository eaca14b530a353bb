#pragma once
#include <algorithm>
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

namespace tessera::server {

/// A job as the scheduler knows it.
struct JobEntry {
  JobEntry(JobId number, std::shared_ptr<const JobPlan> plan, std::uint32_t passes_ahead)
      : id(number), priority(plan->spec.priority), tasks(std::move(plan), passes_ahead) {}

  enum class State { open, paused, done, failed, cancelled };

  JobId id;
  State state = State::open;
  int priority;
  TaskTable tasks;
  BlameTable blame;
  std::optional<Digest> build;  // of its first worker
  bool granted = false;         // a lease, ever
  std::string error;

  TasksOut out;  // what is leased
  // Looked up, never walked through: its order is not determined.
  std::unordered_map<TaskId, LeaseId> journaling;

  std::set<std::string> unable;  // identities that could not prepare it and are not asked again
  std::set<std::string> unable_ever;
  int unable_times = 0;
  std::string unable_reason;  // the last

  std::set<std::string> lost_preparing;  // identities, since a worker was ready

  double served = 0;  // thread-seconds granted, by estimate: the share that fairness compares
  Meter pace;         // samples a thread-second
  double preparation_seconds = 0;  // from a worker's first lease to its ready, smoothed
  Meter progress;                  // samples a second, all workers
  Instant progress_mark{};         // up to where `progress` has been told

  [[nodiscard]] const JobPlan& plan() const { return tasks.plan(); }
  /// Not ended: results are taken.
  [[nodiscard]] bool live() const { return state == State::open || state == State::paused; }
  /// It has something to hand out.
  [[nodiscard]] bool has_work() {
    return state == State::open && (!blame.waiting().empty() || tasks.peek().has_value());
  }
  [[nodiscard]] bool takes(const Digest& worker_build) const {
    return plan().spec.mixed || !build || *build == worker_build;
  }
  /// A worker was ready so long after its first lease.
  void prepared_in(double took) {
    lost_preparing.clear();
    preparation_seconds =
        preparation_seconds == 0 ? took : 0.75 * preparation_seconds + 0.25 * took;
  }
  /// What a task costs in thread-seconds; next to nothing while that is not known.
  [[nodiscard]] double cost(std::int64_t samples) const {
    return static_cast<double>(samples) / (pace.known() ? pace.rate() : 1e6);
  }
};

}  // namespace tessera::server
