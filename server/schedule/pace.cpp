// How fast a job gets on.
#include <algorithm>

#include "server/schedule/state.hpp"

namespace tessera::server {
namespace {

/// The part of a worker that works for this job: by what it holds, and less what is done of it.
struct Share {
  double mine = 0, all = 0;  // samples held
  double done = 0;           // work
};

Share share_of(const WorkerEntry& worker, const JobEntry& job) {
  Share share;
  for (const auto& [id, part] : worker.parts) {
    const auto held = static_cast<double>(part.samples_held);
    share.all += held;
    if (id == job.id) share.mine = held;
  }
  for (const auto& [number, held] : worker.leases) {
    if (!held.runs) break;  // they are begun in this order
    if (held.job != job.id || held.fraction == 0) continue;
    share.done += held.fraction * static_cast<double>(held.samples) * job.left.cost(held.task.tile);
  }
  return share;
}

}  // namespace

std::optional<Pace> Scheduler::State::pace_of(const JobEntry& job, Instant now) const {
  if (job.state != JobEntry::State::open || !job.pace.known() || job.at.empty())
    return std::nullopt;
  Pace pace;
  pace.work = job.left.work();
  pace.workers = 0;
  double measured_threads = 0, measured_power = 0, other_threads = 0;
  for (const auto& [id, leases] : job.at) {
    const WorkerEntry& worker = workers.at(id);
    const Share share = share_of(worker, job);
    const double part = share.all > 0 ? share.mine / share.all : 1;
    const WorkerEntry::Part& its = worker.parts.at(job.id);
    const double threads = std::max(1, worker.info.threads);
    if (its.power.known()) {
      measured_power += part * its.power.rate();
      measured_threads += part * threads;
    } else {
      other_threads += part * threads;
    }
    pace.work -= share.done;
    pace.workers += part;
  }
  if (measured_power <= 0) return std::nullopt;
  pace.work = std::max(0.0, pace.work);
  // Who was not measured yet is as fast as the others, by threads.
  pace.power = measured_power * (1 + other_threads / measured_threads);
  const PassPlan& passes = job.plan().passes;
  std::int64_t longest = passes.pass(passes.count() - 1).count;
  if (passes.count() > 1) longest = std::max(longest, passes.pass(passes.count() - 2).count);
  const auto samples = static_cast<double>(job.plan().grid.tile(0).pixels() * longest);
  pace.task_seconds = samples * job.left.mean_cost() * pace.workers / pace.power;
  pace.elapsed = seconds(now - job.begun);
  pace.spread = job.left.spread();
  pace.changes = job.changes;
  pace.losses = job.losses;
  return pace;
}

}  // namespace tessera::server
