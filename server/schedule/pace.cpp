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

/// Samples of the longest of the last two of so many passes: the last may be what was left.
std::int64_t longest_pass(const JobEntry& job, std::uint32_t passes) {
  const PassPlan& plan = job.plan().passes;
  const std::int64_t last = plan.pass(passes - 1).count;
  return passes < 2 ? last : std::max(last, plan.pass(passes - 2).count);
}

}  // namespace

std::vector<const WorkerEntry*> Scheduler::State::at_work(const JobEntry& job, bool or_were) const {
  std::vector<const WorkerEntry*> found;
  for (const auto& [id, leases] : job.at) found.push_back(&workers.at(id));
  if (!found.empty() || !or_were) return found;
  for (const auto& [id, worker] : workers)
    if (worker.parts.contains(job.id) && !worker.draining && !worker.barred)
      found.push_back(&worker);
  return found;
}

std::optional<Pace> Scheduler::State::pace_of(const JobEntry& job, Instant now) const {
  const double spared = job.watched() ? job.tasks.spared() : 0;
  return pace_to(job, job.tasks.expected_passes(), spared, false, now);
}

std::optional<Pace> Scheduler::State::pace_of(const JobEntry& job, std::uint32_t passes,
                                              Instant now) const {
  const PassPlan& plan = job.plan().passes;
  const std::int64_t spared = plan.samples() - plan.pass(passes - 1).end();
  return pace_to(job, passes, static_cast<double>(spared), passes < plan.count(), now);
}

std::optional<Pace> Scheduler::State::pace_to(const JobEntry& job, std::uint32_t passes,
                                              double spared, bool or_were, Instant now) const {
  if (job.state != JobEntry::State::open || !job.pace.known()) return std::nullopt;
  Pace pace;
  pace.work = job.left.work();
  if (spared > 0) pace.work -= job.left.work_of(spared);
  pace.workers = 0;
  double measured_threads = 0, measured_power = 0, other_threads = 0;
  for (const WorkerEntry* at_it : at_work(job, or_were)) {
    const WorkerEntry& worker = *at_it;
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
  const std::int64_t longest = longest_pass(job, passes);
  const auto samples = static_cast<double>(job.plan().grid.tile(0).pixels() * longest);
  pace.task_seconds = samples * job.left.mean_cost() * pace.workers / pace.power;
  pace.elapsed = seconds(now - job.begun);
  pace.spread = job.left.spread();
  pace.changes = job.changes;
  pace.losses = job.losses;
  share_with_others(job, now, pace);
  return pace;
}

const std::map<JobId, Scheduler::State::Power>& Scheduler::State::powers_of_all(Instant now) const {
  if (powers && powers->first == now) return powers->second;
  struct Measured {
    double power = 0, threads = 0;
  };
  std::map<JobId, Measured> measured;
  std::map<Digest, double> threads_of;  // by build
  for (const auto& [id, worker] : workers) {
    if (worker.draining || worker.barred) continue;
    const double threads = std::max(1, worker.info.threads);
    threads_of[worker.info.build_id] += threads;
    for (const auto& [job, part] : worker.parts) {
      if (!part.power.known()) continue;
      Measured& so_far = measured[job];
      so_far.power += part.power.rate();
      so_far.threads += threads;
    }
  }
  auto& found = powers.emplace(now, std::map<JobId, Power>()).second;
  for (const auto& [id, its] : measured) {
    const auto job = jobs.find(id);
    if (job == jobs.end()) continue;
    double threads = 0;
    for (const auto& [build, all] : threads_of)
      if (job->second.takes(build)) threads += all;
    const JobEntry& entry = job->second;
    const double spared = entry.watched() ? entry.left.work_of(entry.tasks.spared()) : 0;
    found[id] = {its.power * std::max(1.0, threads / its.threads),
                 std::max(0.0, entry.left.work() - spared)};
  }
  return found;
}

void Scheduler::State::share_with_others(const JobEntry& job, Instant now, Pace& pace) const {
  if (order.size() < 2 || job.max_workers > 0) return;
  const auto& all = powers_of_all(now);
  const auto own = all.find(job.id);
  if (own == all.end()) return;
  for (const JobEntry* other : order) {
    if (other == &job || other->state != JobEntry::State::open) continue;
    const auto its = all.find(other->id);
    // Of one that nobody has been measured at yet nothing is known: it may be like this.
    const double alone =
        its == all.end() ? pace.work / own->second.power : its->second.left / its->second.power;
    pace.rivals.push_back({alone, other->weight()});
  }
  if (pace.rivals.empty()) return;
  pace.power = own->second.power;
  pace.weight = job.weight();
}

}  // namespace tessera::server
