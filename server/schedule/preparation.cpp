// Preparations that fail: what is held against the job, and what is not held against workers.
#include <algorithm>
#include <string_view>
#include <utility>

#include "server/schedule/failures.hpp"
#include "server/schedule/state.hpp"

namespace tessera::server {

bool Scheduler::State::anyone_ready(const JobEntry& job) const {
  return std::any_of(workers.begin(), workers.end(), [&](const auto& entry) {
    const auto part = entry.second.parts.find(job.id);
    return part != entry.second.parts.end() && part->second.ready;
  });
}

std::size_t Scheduler::State::names_preparing(const JobEntry& job) const {
  std::set<std::string_view> names;
  for (const auto& [id, leases] : job.at) {
    const WorkerEntry& holder = workers.at(id);
    const auto part = holder.parts.find(job.id);
    if (part == holder.parts.end() || !part->second.ready) names.insert(holder.info.name);
  }
  return names.size();
}

void Scheduler::State::lost_while_preparing(JobEntry& job, const WorkerEntry& lost, Instant now,
                                            Actions& actions) {
  crashed[{job.plan().spec.bundle, lost.info.name}].insert(lost.info.identity);
  // Workers that are lost at once may have been lost with a switch or a rack.
  const auto part = lost.parts.find(job.id);
  if (part == lost.parts.end() || part->second.begun < job.last_lost_preparing) return;
  job.last_lost_preparing = now;
  job.lost_preparing.insert(lost.info.identity);
  if (anyone_ready(job) ||
      job.lost_preparing.size() < static_cast<std::size_t>(settings.deaths_alone))
    return;
  fail(job, fmt::format("preparing its scene ended {} workers in a row", job.lost_preparing.size()),
       actions);
}

void Scheduler::State::judge_preparation(JobEntry& job, const std::string& reason,
                                         Actions& actions) {
  const auto most = static_cast<std::size_t>(settings.errors_said);
  const bool prepared = job.tasks.closed() > 0 || anyone_ready(job);
  const bool nobody_left = !anyone_else(job, job.unable);
  // A few broken machines that are quick to fail say nothing while many others still prepare it.
  const bool by_different = job.unable_names.size() >= std::max(most, names_preparing(job));
  const bool by_all = nobody_left && static_cast<std::size_t>(job.unable_times) >= most;
  if (!prepared && (by_different || by_all)) {
    fail(job, fmt::format("no worker could prepare it, last: {}", reason), actions);
  } else if (nobody_left) {
    job.unable.clear();
    work_appeared = true;
  }
}

std::vector<HeldLease> Scheduler::State::end_all(WorkerEntry& worker, const JobEntry& job) {
  std::vector<HeldLease> given_back;
  for (auto held = worker.leases.begin(); held != worker.leases.end();) {
    const std::uint64_t number = (held++)->first;
    if (worker.leases.at(number).job == job.id) given_back.push_back(end_lease(worker, number));
  }
  worker.parts.erase(job.id);
  return given_back;
}

void Scheduler::State::lacks_files(WorkerEntry& worker, JobEntry& job, const std::string& reason) {
  job.without_files.insert(worker.info.identity);
  job.without_files_reason = reason;
  for (const HeldLease& held : end_all(worker, job)) put_back(job, held.task);
}

void Scheduler::State::could_not_prepare(WorkerEntry& worker, JobEntry& job,
                                         const std::string& reason, Instant now, Actions& actions) {
  const std::vector<HeldLease> given_back = end_all(worker, job);
  job.unable.insert(worker.info.identity);
  job.unable_names.insert(worker.info.name);
  ++job.unable_times;
  job.unable_reason = reason;
  rest(worker, now);
  for (const HeldLease& held : given_back) put_back(job, held.task);
  judge_preparation(job, reason, actions);
}

void Scheduler::State::give_up_preparation(WorkerEntry& worker, Instant now, Actions& actions) {
  const JobId id = worker.leases.begin()->second.job;
  const std::string reason =
      fmt::format("its preparation did not get on for {:.0f} s", seconds(settings.preparation));
  RevokeLeases revoke{worker.id, {}, reason, true};
  for (const auto& [number, held] : worker.leases)
    if (held.job == id) revoke.leases.push_back(held.id);
  const std::vector<LeaseId> given_up = revoke.leases;
  actions.emplace_back(std::move(revoke));
  worker.got_on = now;  // what it may prepare next begins now
  if (worker.hung) {
    // It had no chance to begin with this one.
    for (const LeaseId& lease : given_up) give_back(worker, lease.number, std::nullopt, actions);
    worker.parts.erase(id);
    return count_without();
  }
  hangs(worker, id);
  worker.hung_counts = true;
  actions.emplace_back(preparation_failed(worker, id, AttemptFailed::Outcome::stalled, reason));
  if (JobEntry* entry = live_job(id)) could_not_prepare(worker, *entry, reason, now, actions);
}

void Scheduler::State::hangs(WorkerEntry& worker, JobId job) {
  worker.hung_said = true;
  if (std::exchange(worker.hung, job) == job) return;
  worker.hung_counts = false;
  timers.arm(worker, worker.due(settings));
}

void Scheduler::State::still_hangs(WorkerEntry& worker, Instant now, Actions& actions) {
  worker.got_on = now;
  JobEntry* entry = live_job(*worker.hung);
  if (entry == nullptr || !worker.hung_counts) return;
  entry->unable_names.insert(worker.info.name);
  ++entry->unable_times;
  judge_preparation(*entry, entry->unable_reason, actions);
}

Actions Scheduler::worker_lacks_files(WorkerId worker, JobId job, const std::string& reason,
                                      Instant now) {
  Actions actions;
  WorkerEntry* entry = state_->worker(worker);
  if (entry == nullptr) return actions;
  entry->heard = now;
  JobEntry* lacked = state_->live_job(job);
  if (lacked != nullptr && entry->parts.contains(job)) {
    actions.emplace_back(preparation_failed(*entry, job, AttemptFailed::Outcome::failed, reason));
    state_->lacks_files(*entry, *lacked, reason);
  }
  state_->settle(now, actions);
  return actions;
}

}  // namespace tessera::server
