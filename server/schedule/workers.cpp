// Workers: how they come, speak, fall silent and go.
#include <algorithm>
#include <utility>

#include "server/schedule/failures.hpp"
#include "server/schedule/state.hpp"

namespace tessera::server {

WorkerEntry* Scheduler::State::worker(WorkerId id) {
  const auto found = workers.find(id);
  return found == workers.end() ? nullptr : &found->second;
}

std::vector<WorkerEntry*> Scheduler::State::named(const std::string& name) {
  std::vector<WorkerEntry*> found;
  for (auto& [id, entry] : workers)
    if (entry.info.name == name) found.push_back(&entry);
  return found;
}

namespace {

/// Jobs of which it holds leases and has not built the scene.
std::set<JobId> in_preparation(const WorkerEntry& worker) {
  std::set<JobId> jobs;
  for (const auto& [number, held] : worker.leases) {
    const auto part = worker.parts.find(held.job);
    if (part == worker.parts.end() || !part->second.ready) jobs.insert(held.job);
    break;  // one at a time, in the order of its leases
  }
  return jobs;
}

}  // namespace

void Scheduler::State::went_away(const std::string& identity) {
  Identity& gone = identities.at(identity);
  gone.connected = false;
  gone.left = ++last_left;
  away.emplace_back(gone.left, identity);
  while (away.size() > away_most) {
    const auto& [left, first] = away.front();
    const auto known = identities.find(first);
    if (known != identities.end() && !known->second.connected && known->second.left == left)
      identities.erase(known);
    away.pop_front();
  }
}

void Scheduler::State::count_without() {
  // The last that a scene did not crash, or that a suspect was not lost with, may have gone.
  work_appeared = true;
  for (JobEntry* entry : order) {
    // Those who could are gone: the others may try again.
    if (!entry->unable.empty() && !anyone_else(*entry, entry->unable)) entry->unable.clear();
  }
}

void Scheduler::State::disconnect(WorkerId id, const std::optional<Charge>& charge, Instant now,
                                  Actions& actions) {
  // Taken out first: what follows speaks to the workers that are there.
  auto node = workers.extract(id);
  WorkerEntry& gone = node.mapped();
  touched.erase(id);
  idlers.erase(id);
  if (const auto group = hungry.find(gone.info.build_id); group != hungry.end()) {
    group->second.erase(id);
    if (group->second.empty()) hungry.erase(group);
  }
  for (JobEntry* entry : order) {
    const double others = static_cast<double>(entry->at.size());
    if (!entry->at.contains(id)) continue;
    entry->changes += 1 / (others * others);
    entry->losses += 1 / others;
  }
  const std::set<JobId> unprepared = charge ? in_preparation(gone) : std::set<JobId>{};
  give_back_all(gone, charge, actions);
  for (const JobId job : unprepared) {
    if (JobEntry* entry = live_job(job)) lost_while_preparing(*entry, gone, now, actions);
  }
  touched.erase(id);
  count_without();
}

void Scheduler::State::drop(WorkerEntry& worker, bool blame, const std::string& reason, Instant now,
                            Actions& actions) {
  const WorkerId id = worker.id;
  dropped.emplace(id, worker.info.identity);
  actions.emplace_back(DropWorker{id, reason});
  std::optional<Charge> charge;
  if (blame) charge = Charge{AttemptFailed::Outcome::lost, reason};
  disconnect(id, charge, now, actions);
}

Scheduler::Joined Scheduler::worker_joined(const WorkerInfo& info, Instant now) {
  Actions actions;
  State::Identity& identity = state_->identities[info.identity];
  if (WorkerEntry* earlier = state_->worker(identity.worker)) {
    state_->drop(*earlier, false, "its worker came again on another connection", now, actions);
  }
  if (identity.worker == 0 || identity.connected) identity.worker = ++state_->last_worker;
  identity.connected = true;
  const auto place = state_->workers.try_emplace(identity.worker, identity.worker, info, now).first;
  WorkerEntry& worker = place->second;
  worker.barred = state_->quarantines.contains(info.name);
  for (auto& [scene, lost] : state_->crashed) lost.erase(info.identity);
  std::erase_if(state_->crashed, [](const auto& entry) { return entry.second.empty(); });
  for (JobEntry* job : state_->order) {
    job->lost_preparing.erase(info.identity);
    for (const TaskId& task : job->blame.forgive(info.identity)) state_->put_back(*job, task);
  }
  state_->timers.arm(worker, worker.due(state_->settings));
  state_->touched.insert(worker.id);
  state_->settle(now, actions);
  return {worker.id, std::move(actions)};
}

Actions Scheduler::worker_left(WorkerId worker, bool clean, Instant now) {
  Actions actions;
  if (const auto told = state_->dropped.find(worker); told != state_->dropped.end()) {
    const auto identity = state_->identities.find(told->second);
    if (identity != state_->identities.end() && identity->second.worker == worker)
      state_->went_away(told->second);
    state_->dropped.erase(told);
  } else if (const WorkerEntry* entry = state_->worker(worker)) {
    state_->went_away(entry->info.identity);
    std::optional<State::Charge> charge;
    if (!clean && !entry->draining)
      charge = {AttemptFailed::Outcome::lost, "its connection ended without a word"};
    state_->disconnect(worker, charge, now, actions);
  }
  state_->settle(now, actions);
  return actions;
}

void Scheduler::worker_heard(WorkerId worker, Instant now) {
  if (WorkerEntry* entry = state_->worker(worker)) entry->heard = now;
}

void Scheduler::excuse_worker(WorkerId worker, Instant now) {
  if (WorkerEntry* entry = state_->worker(worker)) entry->excused(now);
}

Actions Scheduler::worker_preparing(WorkerId worker, JobId job, double fraction, Instant now) {
  WorkerEntry* entry = state_->worker(worker);
  if (entry == nullptr) return {};
  entry->heard = entry->advanced = now;
  const auto place = entry->parts.find(job);
  if (place == entry->parts.end() || place->second.samples_held == 0) {
    state_->hangs(*entry, job);
    return {};
  }
  WorkerEntry::Part& part = place->second;
  // Workers keep few scenes: one that had been built, or begun, may have to be built anew.
  const bool anew = part.ready || fraction < part.fraction;
  if (!anew && fraction <= part.fraction) return {};
  if (std::exchange(part.ready, false)) part.begun = now;
  part.fraction = fraction;
  entry->got_on = now;
  return {};
}

Actions Scheduler::worker_ready(WorkerId worker, JobId job, Instant now) {
  Actions actions;
  WorkerEntry* entry = state_->worker(worker);
  if (entry == nullptr) return actions;
  entry->heard = now;
  const auto part = entry->parts.find(job);
  if (part != entry->parts.end() && !part->second.ready) {
    part->second.ready = true;
    if (JobEntry* entry_of_job = state_->live_job(job))
      entry_of_job->prepared_in(seconds(now - part->second.begun));
    entry->gets_on(now);
    const bool others_run =
        std::any_of(entry->leases.begin(), entry->leases.end(), [&](const auto& lease) {
          return lease.second.job != job && entry->parts[lease.second.job].ready;
        });
    if (!others_run) entry->measured(now);
  }
  state_->settle(now, actions);
  return actions;
}

Actions Scheduler::worker_progress(WorkerId worker,
                                   const std::vector<std::pair<LeaseId, double>>& running,
                                   Instant now) {
  Actions actions;
  WorkerEntry* entry = state_->worker(worker);
  if (entry == nullptr) return actions;
  entry->heard = now;
  for (const auto& [lease, fraction] : running) {
    const auto held = entry->leases.find(lease.number);
    if (held == entry->leases.end() || held->second.id != lease) continue;
    if (!held->second.runs) state_->begin_running(*entry, held->second, now);
    if (fraction <= held->second.fraction) continue;
    held->second.fraction = fraction;
    held->second.advanced = now;
    entry->gets_on(now);
    entry->reported = now;
  }
  if (entry->hung && !std::exchange(entry->hung_said, false)) {
    entry->hung.reset();
    entry->got_on = now;
    state_->touched.insert(worker);
  }
  for (auto& [number, held] : entry->leases) {
    if (!held.runs) break;
    const bool named = std::any_of(running.begin(), running.end(),
                                   [id = held.id](const auto& one) { return one.first == id; });
    if (!named) held.stall = state_->settings.stall;  // rendered, and on its way
  }
  if (!running.empty()) state_->timers.arm(*entry, entry->due(state_->settings));
  const bool let_go = std::none_of(running.begin(), running.end(), [&](const auto& one) {
    return entry->expired.contains(one.first);
  });
  // It has heard that its leases are over and runs none of them any more: it is alive.
  if (!entry->expired.empty() && let_go) {
    entry->expired.clear();
    state_->touched.insert(worker);
  }
  state_->settle(now, actions);
  return actions;
}

Actions Scheduler::worker_failed(WorkerId worker, JobId job, std::optional<LeaseId> lease,
                                 const std::string& reason, Instant now) {
  Actions actions;
  WorkerEntry* entry = state_->worker(worker);
  JobEntry* failed = state_->live_job(job);
  if (entry == nullptr) return actions;
  entry->heard = now;
  const std::string& identity = entry->info.identity;
  if (lease) {
    const auto held = entry->leases.find(lease->number);
    if (held != entry->leases.end() && held->second.id == *lease && held->second.job == job) {
      const HeldLease ended = state_->end_lease(*entry, lease->number);
      actions.emplace_back(attempt_failed(*entry, ended, AttemptFailed::Outcome::failed, reason));
      state_->rest(*entry, now);
      state_->fault_of(*entry, job, reason);
      if (failed != nullptr && state_->is_awaited(*failed, ended.task)) {
        state_->error_said(*failed, ended.task, identity, reason, actions);
      }
    }
  } else if (failed != nullptr && entry->parts.contains(job)) {
    actions.emplace_back(preparation_failed(*entry, job, AttemptFailed::Outcome::failed, reason));
    state_->could_not_prepare(*entry, *failed, reason, now, actions);
  }
  state_->settle(now, actions);
  return actions;
}

Actions Scheduler::drain_worker(WorkerId worker, Instant now) {
  Actions actions;
  if (WorkerEntry* entry = state_->worker(worker)) {
    entry->draining = true;
    state_->unreserve(*entry);
    state_->touched.insert(worker);
  }
  state_->settle(now, actions);
  return actions;
}

Actions Scheduler::quarantine(const std::string& name, const std::string& reason, Instant now) {
  Actions actions;
  for (WorkerEntry* entry : state_->bar(name, reason)) {
    RevokeLeases revoke{entry->id, {}, "the worker is quarantined: " + reason};
    for (const auto& [number, held] : entry->leases) revoke.leases.push_back(held.id);
    if (!revoke.leases.empty()) actions.emplace_back(std::move(revoke));
    state_->give_back_all(*entry, std::nullopt, actions);
  }
  state_->settle(now, actions);
  return actions;
}

Actions Scheduler::release(const std::string& name, Instant now) {
  Actions actions;
  state_->quarantines.erase(name);
  for (WorkerEntry* entry : state_->named(name)) {
    State::Identity& identity = state_->identities[entry->info.identity];
    identity.offences = 0;
    identity.failures.clear();
    entry->barred = false;
    entry->told_barred = false;
    state_->touched.insert(entry->id);
  }
  state_->settle(now, actions);
  return actions;
}

}  // namespace tessera::server
