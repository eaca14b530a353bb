// What goes out: which job a worker serves, and which task.
#include <algorithm>
#include <cassert>
#include <utility>

#include "server/schedule/state.hpp"

namespace tessera::server {
namespace {

/// So many seconds of a worker does a job that it has prepared (or is preparing) go before a job
/// that is owed more: scenes are not built twice for the sake of a moment's fairness.
constexpr double loyalty_seconds = 10;
constexpr Duration settling = std::chrono::seconds(10);

}  // namespace

bool Scheduler::State::able(const JobEntry& job, const WorkerEntry& worker) const {
  return job.state == JobEntry::State::open && job.takes(worker.info.build_id) &&
         !job.unable.contains(worker.info.identity) &&
         !job.without_files.contains(worker.info.identity);
}

bool Scheduler::State::eligible(const JobEntry& job, const WorkerEntry& worker) const {
  if (!able(job, worker)) return false;
  const Digest& scene = job.plan().spec.bundle;
  if (crashed.empty() || !crashed.contains({scene, worker.info.name})) return true;
  // No scene twice for a worker that it crashed, while there is another.
  return std::none_of(workers.begin(), workers.end(), [&](const auto& entry) {
    const WorkerEntry& other = entry.second;
    return !other.draining && !other.barred && !other.stalled() && able(job, other) &&
           !crashed.contains({scene, other.info.name});
  });
}

bool Scheduler::State::anyone_else(const JobEntry& job, const std::set<std::string>& but,
                                   const std::set<std::string>& names) const {
  return std::any_of(workers.begin(), workers.end(), [&](const auto& entry) {
    const WorkerEntry& worker = entry.second;
    return !worker.draining && !worker.barred && !worker.stalled() && eligible(job, worker) &&
           !but.contains(worker.info.identity) && !names.contains(worker.info.name);
  });
}

bool Scheduler::State::for_another(const JobEntry& job, const TaskId& task,
                                   const WorkerEntry& worker) const {
  const Charges* charges = job.blame.find(task);
  const bool tried = charges != nullptr && (charges->erred.contains(worker.info.identity) ||
                                            charges->lost_names.contains(worker.info.name));
  return tried && anyone_else(job, charges->erred, charges->lost_names);
}

const TaskId* Scheduler::State::suspect_for(const JobEntry& job, const WorkerEntry& worker) const {
  for (const TaskId& task : job.blame.waiting()) {
    if (!job.tasks.within(task)) continue;  // came early, from before a start
    if (!for_another(job, task, worker)) return &task;
  }
  return nullptr;
}

JobEntry* Scheduler::State::pick(const WorkerEntry& worker) {
  JobEntry* best = nullptr;
  double best_share = 0, loyalty = 0;
  for (JobEntry* job : order) {
    if (!job->has_place_for(worker.id) || !eligible(*job, worker)) continue;
    if (suspect_for(*job, worker) == nullptr && !job->tasks.peek()) continue;
    double share = job->served;
    // Counted at the weight of the heaviest, which comes first: what is urgent does not wait long.
    if (best == nullptr)
      loyalty = loyalty_seconds * std::max(1, worker.info.threads) / job->weight();
    if (worker.parts.contains(job->id)) share -= loyalty;
    if (best == nullptr || share < best_share) {
      best = job;
      best_share = share;
    }
  }
  return best;
}

void Scheduler::State::grant(WorkerEntry& worker, JobEntry& job, const TaskId& task, bool alone,
                             Instant now, Actions& actions) {
  assert(job.tasks.state(task) == TaskTable::State::taken);
  const bool copy = job.out.contains(task);
  const LeaseId lease = numbers.next(worker.info.identity, job.id, task);
  const std::int64_t samples = job.tasks.samples(task);
  const auto [place, fresh] = worker.parts.try_emplace(job.id);
  WorkerEntry::Part& part = place->second;
  if (fresh) {
    part.begun = now;
    const double others = static_cast<double>(job.at.size());
    // Those who come with the job are its workers, and no change of them.
    if (job.granted && worker.joined > job.begun + settling && others > 0)
      job.changes += 1 / ((others + 1) * (others + 1));
  }
  if (worker.leases.empty()) {
    worker.advanced = worker.got_on = now;
    worker.busy_since = now;
  }
  worker.leases.emplace(lease.number, HeldLease{lease, job.id, task, samples, now});
  worker.alone = alone;
  part.samples_held += samples;
  job.out.add(task, Holder{worker.id, lease});
  if (const double speed = part.speed.rate(); speed > 0 && !copy) {
    const double held = static_cast<double>(part.samples_held) / speed;
    job.out.expect(task, now + std::chrono::duration_cast<Duration>(
                                   std::chrono::duration<double>(std::min(held, 1e9))));
  }
  if (!copy) {  // no other job had work for who would have idled
    if (job.at.empty()) {
      // While it could not be worked at it saved up no more than a worker's loyalty.
      const double loyalty = loyalty_seconds * std::max(1, worker.info.threads) / job.weight();
      job.served = std::max(job.served, virtual_time - loyalty);
    }
    virtual_time = std::max(virtual_time, job.served);
    job.served += job.cost(samples) / job.weight();
  }
  ++job.at[worker.id];
  idlers.erase(worker.id);
  if (!job.build) job.build = worker.info.build_id;
  if (!job.granted) job.progress_mark = job.begun = now;
  if (!job.started) job.started = now;
  job.granted = true;
  timers.arm(worker, worker.due(settings));
  actions.emplace_back(GrantLease{worker.id, lease, job.id, task});
}

bool Scheduler::State::take_over(WorkerEntry& idle, Instant now, Actions& actions) {
  for (const WorkerId id : reserving) {
    WorkerEntry& busy = *worker(id);
    const auto [number, task] = *busy.reserved;
    JobEntry* job = live_job(number);
    if (job == nullptr || !job->has_place_for(idle.id) || !eligible(*job, idle) ||
        !is_aside(*job, task))
      continue;
    const Charges* charges = job->blame.find(task);
    if (charges != nullptr && charges->erred.contains(idle.info.identity)) continue;
    if (for_another(*job, task, idle)) continue;
    clear_reservation(busy);
    touched.insert(id);
    grant(idle, *job, task, true, now, actions);
    return true;
  }
  return false;
}

bool Scheduler::State::grant_one(WorkerEntry& worker, Instant now, Actions& actions) {
  if (worker.reserved) {
    const auto [id, task] = *worker.reserved;
    clear_reservation(worker);
    JobEntry* job = live_job(id);
    if (job != nullptr && is_aside(*job, task)) {
      // Others may have come to the job since.
      if (job->has_place_for(worker.id) && eligible(*job, worker)) {
        grant(worker, *job, task, true, now, actions);
        return true;
      }
      set_aside(*job, task);
    }
  }
  JobEntry* job = pick(worker);
  if (job == nullptr) return worker.leases.empty() && take_over(worker, now, actions);
  if (const TaskId* waiting = suspect_for(*job, worker)) {
    const TaskId task = *waiting;
    job->blame.taken(task);
    if (!worker.leases.empty()) {
      worker.reserved = {job->id, task};
      reserving.insert(worker.id);
      return false;
    }
    grant(worker, *job, task, true, now, actions);
    return true;
  }
  const TaskId task = *job->tasks.peek();
  const bool took = job->tasks.take(task);
  assert(took);
  static_cast<void>(took);
  grant(worker, *job, task, false, now, actions);
  return true;
}

void Scheduler::State::fill(WorkerEntry& worker, Instant now, Actions& actions) {
  while (worker.has_room(settings) && grant_one(worker, now, actions)) {
  }
  grant_copy(worker, now, actions);
  auto& same_build = hungry[worker.info.build_id];
  if (worker.has_room(settings) && worker.leases.empty()) {
    idlers.insert(worker.id);
  } else {
    idlers.erase(worker.id);
  }
  if (worker.has_room(settings)) {
    same_build.insert(worker.id);
  } else {
    same_build.erase(worker.id);
    if (same_build.empty()) hungry.erase(worker.info.build_id);
  }
}

void Scheduler::State::serve_hungry(Instant now, Actions& actions) {
  const auto any_work = [&](const Digest& build) {
    return std::any_of(order.begin(), order.end(),
                       [&](JobEntry* job) { return job->takes(build) && job->has_work(); });
  };
  for (auto group = hungry.begin(); group != hungry.end();) {
    auto& [build, ids] = *group;
    // One task to each in turn, so that little work is spread over many.
    bool granted = true;
    while (granted && !ids.empty() && any_work(build)) {
      granted = false;
      for (auto id = ids.begin(); id != ids.end();) {
        WorkerEntry& entry = *worker(*id);
        if (grant_one(entry, now, actions)) {
          granted = true;
        } else if (entry.has_room(settings) && !any_work(build)) {
          break;
        }
        id = entry.has_room(settings) ? std::next(id) : ids.erase(id);
      }
    }
    // A job that has its most of workers has work for those alone.
    for (JobEntry* job : order) {
      if (!job->full() || !job->has_open()) continue;
      const auto members = job->at;
      for (const auto& [id, leases] : members) {
        if (!ids.contains(id)) continue;
        WorkerEntry& entry = *worker(id);
        while (entry.has_room(settings) && grant_one(entry, now, actions)) {
        }
        if (!entry.has_room(settings)) ids.erase(id);
      }
    }
    // What busy workers were to run alone is for those who have nothing at all.
    for (auto id = ids.begin(); id != ids.end() && !reserving.empty();) {
      WorkerEntry& entry = *worker(*id);
      if (entry.leases.empty()) grant_one(entry, now, actions);
      id = entry.has_room(settings) ? std::next(id) : ids.erase(id);
    }
    group = ids.empty() ? hungry.erase(group) : std::next(group);
  }
}

void Scheduler::State::settle(Instant now, Actions& actions) {
  while (!touched.empty() || work_appeared || offer_passes(now, actions)) {
    while (!touched.empty()) {
      const WorkerId id = *touched.begin();
      touched.erase(touched.begin());
      WorkerEntry* entry = worker(id);
      if (entry == nullptr) continue;
      if (entry->barred && !std::exchange(entry->told_barred, true))
        actions.emplace_back(WorkerQuarantined{id, quarantines.at(entry->info.name)});
      if (entry->offended) {
        drop(*entry, false,
             "it sent results that it was not asked for, or that were not what was asked", now,
             actions);
      } else {
        fill(*entry, now, actions);
      }
    }
    if (std::exchange(work_appeared, false)) serve_hungry(now, actions);
  }
  plan_tail_look(now);
}

}  // namespace tessera::server
