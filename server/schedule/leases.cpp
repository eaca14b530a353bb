// What comes back without a result: leases that end, and what is held against whom.
#include <algorithm>
#include <cmath>

#include "server/schedule/failures.hpp"
#include "server/schedule/state.hpp"

namespace tessera::server {

HeldLease Scheduler::State::end_lease(WorkerEntry& worker, std::uint64_t number) {
  const auto node = worker.leases.extract(number);
  const HeldLease& held = node.mapped();
  if (const auto part = worker.parts.find(held.job); part != worker.parts.end())
    part->second.samples_held -= held.samples;
  if (worker.leases.empty()) worker.alone = false;
  if (JobEntry* entry = job(held.job)) {
    entry->out.remove(held.task, held.id);
    if (const auto place = entry->at.find(worker.id);
        place != entry->at.end() && --place->second == 0) {
      if (entry->full()) work_appeared = true;  // for another worker
      entry->at.erase(place);
    }
  }
  touched.insert(worker.id);
  return held;
}

bool Scheduler::State::is_awaited(const JobEntry& job, const TaskId& task) const {
  return job.tasks.state(task) == TaskTable::State::taken && !job.journaling.contains(task);
}

bool Scheduler::State::is_aside(const JobEntry& job, const TaskId& task) const {
  return is_awaited(job, task) && !job.out.contains(task);
}

void Scheduler::State::put_back(JobEntry& job, const TaskId& task) {
  if (!is_aside(job, task)) return;
  if (job.blame.suspect(task)) {
    set_aside(job, task);
  } else {
    job.tasks.reopen(task);
    work_appeared = true;
  }
  // Nothing is out and nothing has come in: the next worker decides the build anew.
  if (job.out.empty() && job.journaling.empty() && job.tasks.closed() == 0) job.build.reset();
}

void Scheduler::State::set_aside(JobEntry& job, const TaskId& task) {
  job.blame.wait(task);
  work_appeared = true;
}

void Scheduler::State::clear_reservation(WorkerEntry& worker) {
  worker.reserved.reset();
  reserving.erase(worker.id);
}

void Scheduler::State::unreserve(WorkerEntry& worker) {
  if (!worker.reserved) return;
  const auto [id, task] = *worker.reserved;
  clear_reservation(worker);
  if (JobEntry* entry = live_job(id)) put_back(*entry, task);
}

void Scheduler::State::lost_while_running(JobEntry& job, const TaskId& task, const WorkerInfo& lost,
                                          bool alone, Actions& actions) {
  Charges& charges = job.blame.charge(task);
  (alone ? charges.lost_alone : charges.lost).insert(lost.identity);
  charges.lost_names.insert(lost.name);
  if (charges.lost_alone.size() < static_cast<std::size_t>(settings.deaths_alone)) return;
  fail(job,
       fmt::format("{} ended {} workers that ran nothing else", text_of(task),
                   charges.lost_alone.size()),
       actions);
}

void Scheduler::State::give_back(WorkerEntry& worker, std::uint64_t number,
                                 const std::optional<Charge>& charge, Actions& actions) {
  const bool alone = worker.alone;
  const HeldLease held = end_lease(worker, number);
  JobEntry* entry = live_job(held.job);
  if (entry == nullptr) return;
  if (charge) actions.emplace_back(attempt_failed(worker, held, charge->outcome, charge->reason));
  if (charge && is_awaited(*entry, held.task))
    lost_while_running(*entry, held.task, worker.info, alone, actions);
  if (entry->live()) put_back(*entry, held.task);
}

void Scheduler::State::give_back_all(WorkerEntry& worker, const std::optional<Charge>& charge,
                                     Actions& actions) {
  // A worker begins its leases in the order in which they came, no more at once than it has
  // threads.
  for (int place = 0; !worker.leases.empty(); ++place) {
    const auto& [number, held] = *worker.leases.begin();
    const auto part = worker.parts.find(held.job);
    const bool ready = part != worker.parts.end() && part->second.ready;
    const bool ran = ready && (place < std::max(1, worker.info.threads) || held.runs);
    if (charge && !ready && place == 0)
      actions.emplace_back(preparation_failed(worker, held.job, charge->outcome, charge->reason));
    give_back(worker, number, ran ? charge : std::nullopt, actions);
  }
  unreserve(worker);
}

void Scheduler::State::begin_running(const WorkerEntry& worker, HeldLease& held, Instant now) {
  constexpr double times_expected = 20;
  held.runs = true;
  held.advanced = now;
  held.stall = settings.stall;
  const auto part = worker.parts.find(held.job);
  if (part == worker.parts.end() || !part->second.speed.known()) return;
  const double expected = static_cast<double>(held.samples) / part->second.speed.rate();
  const double most = seconds(settings.stall);
  const double stall = std::clamp(times_expected * expected, seconds(settings.stall_least), most);
  held.stall = std::chrono::duration_cast<Duration>(std::chrono::duration<double>(stall));
}

void Scheduler::State::expire(WorkerEntry& worker, Instant now, Actions& actions) {
  const bool all = !worker.leases.begin()->second.runs;
  if (all && worker.advanced + settings.stall > now)
    return give_up_preparation(worker, now, actions);
  const Charge charge{AttemptFailed::Outcome::stalled, "no progress for too long"};
  RevokeLeases revoke{worker.id, {}, charge.reason, true};
  for (const auto& [number, held] : worker.leases) {
    if (all || (held.runs && held.advanced + held.stall <= now)) revoke.leases.push_back(held.id);
  }
  worker.expired.insert(revoke.leases.begin(), revoke.leases.end());
  fault_of(worker, worker.leases.begin()->second.job, charge.reason);
  actions.emplace_back(revoke);
  worker.measured(now);
  worker.advanced = now;  // what was queued behind begins now
  if (all) {
    give_back_all(worker, charge, actions);
    return count_without();
  }
  for (const LeaseId& lease : revoke.leases) {
    if (worker.leases.contains(lease.number)) give_back(worker, lease.number, charge, actions);
  }
  count_without();
}

void Scheduler::State::error_said(JobEntry& job, const TaskId& task, const std::string& identity,
                                  const std::string& reason, Actions& actions) {
  Charges& charges = job.blame.charge(task);
  charges.erred.insert(identity);
  ++charges.errors;
  const auto most = static_cast<std::size_t>(settings.errors_said);
  const bool by_different = charges.erred.size() >= most;
  // Where there is no other worker to ask, the same one is asked again.
  const bool by_all =
      static_cast<std::size_t>(charges.errors) >= most && !anyone_else(job, charges.erred);
  if (by_different || by_all) {
    fail(job, fmt::format("{} failed {} times, last: {}", text_of(task), charges.errors, reason),
         actions);
  } else {
    put_back(job, task);
  }
}

void Scheduler::State::rest(WorkerEntry& worker, Instant now) {
  constexpr double first_seconds = 0.25;
  constexpr int doublings_most = 8;
  const double pause = std::ldexp(first_seconds, std::min(worker.errors_in_row, doublings_most));
  ++worker.errors_in_row;
  worker.rests = now + std::chrono::duration_cast<Duration>(std::chrono::duration<double>(pause));
  timers.arm(worker, worker.due(settings));
  touched.insert(worker.id);
}

void Scheduler::State::offend(WorkerEntry& worker) {
  Identity& identity = identities[worker.info.identity];
  if (++identity.offences < settings.offences) return;
  identity.offences = 0;
  bar(worker.info.name,
      "it sent results that it was not asked for, or that were not what was asked");
  worker.offended = true;
  touched.insert(worker.id);
}

void Scheduler::State::fault_of(WorkerEntry& worker, JobId job, const std::string& reason) {
  if (worker.barred) return;
  Identity& identity = identities[worker.info.identity];
  identity.failures[job] = reason;
  // A job that nobody has rendered anything of may be at fault itself.
  int elsewhere = 0;
  std::string said;
  for (const auto& [id, what] : identity.failures) {
    const JobEntry* failed = this->job(id);
    if (failed == nullptr || failed->tasks.closed() == 0) continue;
    ++elsewhere;
    said += fmt::format("{}job {}: {}", said.empty() ? "" : "; ", id, what);
  }
  const bool others = std::any_of(workers.begin(), workers.end(), [&](const auto& entry) {
    return entry.second.info.name != worker.info.name && !entry.second.barred &&
           !entry.second.draining;
  });
  if (elsewhere < settings.jobs_failed || !others) return;
  identity.failures.clear();
  bar(worker.info.name,
      fmt::format("it failed on {} jobs that other workers render ({})", elsewhere, said));
}

std::vector<WorkerEntry*> Scheduler::State::bar(const std::string& name,
                                                const std::string& reason) {
  quarantines[name] = reason;
  std::vector<WorkerEntry*> barred = named(name);
  for (WorkerEntry* worker : barred) {
    worker->barred = true;
    worker->told_barred = false;
    unreserve(*worker);
    touched.insert(worker->id);
  }
  return barred;
}

}  // namespace tessera::server
