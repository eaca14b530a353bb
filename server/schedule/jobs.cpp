// Jobs: how they come, change and end.
#include <algorithm>
#include <tuple>

#include "server/schedule/noise_stop.hpp"
#include "server/schedule/state.hpp"

namespace tessera::server {

JobEntry* Scheduler::State::job(JobId id) {
  const auto found = jobs.find(id);
  return found == jobs.end() ? nullptr : &found->second;
}

JobEntry* Scheduler::State::live_job(JobId id) {
  JobEntry* found = job(id);
  return found != nullptr && found->live() ? found : nullptr;
}

void Scheduler::State::sort_order() {
  std::sort(order.begin(), order.end(), [](const JobEntry* a, const JobEntry* b) {
    return std::tuple(-a->priority, a->id) < std::tuple(-b->priority, b->id);
  });
}

void Scheduler::State::level(JobEntry& job) { job.served = std::max(job.served, virtual_time); }

void Scheduler::State::end_job(JobEntry& job, JobEntry::State state, const std::string& reason,
                               Actions& actions) {
  job.state = state;
  job.error = state == JobEntry::State::failed ? reason : "";
  std::erase(order, &job);
  limited.erase(job.id);
  const Digest& scene = job.plan().spec.bundle;
  const bool used = std::any_of(order.begin(), order.end(), [&](const JobEntry* other) {
    return other->plan().spec.bundle == scene;
  });
  if (!used) std::erase_if(crashed, [&](const auto& entry) { return entry.first.first == scene; });
  for (auto& [id, worker] : workers) {
    RevokeLeases revoke{id, {}, reason};
    for (const auto& [number, held] : worker.leases) {
      if (held.job == job.id) revoke.leases.push_back(held.id);
    }
    for (const LeaseId& lease : revoke.leases) end_lease(worker, lease.number);
    worker.parts.erase(job.id);
    if (worker.reserved && worker.reserved->first == job.id) {
      clear_reservation(worker);
      touched.insert(id);
    }
    if (!revoke.leases.empty()) actions.emplace_back(std::move(revoke));
  }
  job.out.clear();
  job.journaling.clear();
}

void Scheduler::State::fail(JobEntry& job, const std::string& reason, Actions& actions) {
  if (!job.live()) return;
  end_job(job, JobEntry::State::failed, reason, actions);
  actions.emplace_back(JobFailed{job.id, reason});
}

JobEntry* Scheduler::State::add(JobId job, std::shared_ptr<const JobPlan> plan, Instant now,
                                const std::vector<Digest>& earlier) {
  const auto ahead = static_cast<std::uint32_t>(std::clamp(settings.passes_ahead, 1, 32));
  const auto [entry, fresh] = jobs.try_emplace(job, job, std::move(plan), ahead);
  if (!fresh) return nullptr;
  entry->second.progress_mark = now;
  if (entry->second.limited()) limited.insert(job);
  if (entry->second.limited() || entry->second.watched()) offer_first(entry->second, 1);
  entry->second.earlier_plans = {earlier.begin(), earlier.end()};
  order.push_back(&entry->second);
  sort_order();
  level(entry->second);
  return &entry->second;
}

Actions Scheduler::add_job(JobId job, std::shared_ptr<const JobPlan> plan, Instant now,
                           const std::vector<Digest>& earlier) {
  Actions actions;
  if (state_->add(job, std::move(plan), now, earlier) == nullptr) return actions;
  state_->work_appeared = true;
  state_->settle(now, actions);
  return actions;
}

Actions Scheduler::replace_job(JobId job, std::shared_ptr<const JobPlan> plan, Instant now,
                               const std::vector<Digest>& earlier) {
  Actions actions;
  if (JobEntry* before = state_->live_job(job))
    state_->end_job(*before, JobEntry::State::cancelled, "the job was extended", actions);
  state_->jobs.erase(job);
  state_->add(job, std::move(plan), now, earlier)->state = JobEntry::State::paused;
  state_->settle(now, actions);
  return actions;
}

void Scheduler::restore_closed(JobId job, const TaskId& task) {
  JobEntry* entry = state_->live_job(job);
  if (entry == nullptr || !entry->plan().contains(task)) return;
  // What was begun before the start is finished.
  if (task.pass >= entry->tasks.offered(task.frame) && task.pass < entry->tasks.passes(task.frame))
    state_->offer(*entry, task.frame, task.pass + 1);
  if (entry->tasks.close(task)) entry->left.closed(task.tile, entry->tasks.samples(task));
}

bool Scheduler::restore_shortened(JobId job, std::int32_t frame, std::int64_t samples) {
  JobEntry* entry = state_->live_job(job);
  if (entry == nullptr || !entry->plan().spec.frames.contains(frame)) return false;
  const PassPlan& plan = entry->plan().passes;
  const std::uint32_t passes = passes_within(plan, samples);
  if (passes == 0 || passes >= entry->tasks.passes(frame) || plan.pass(passes - 1).end() != samples)
    return false;
  entry->left.cut(plan.samples() - samples);
  entry->tasks.cut(frame, passes);
  return true;
}

void Scheduler::restore_started(JobId job, Instant first_lease) {
  if (JobEntry* entry = state_->live_job(job)) entry->started = first_lease;
}

void Scheduler::restore_build(JobId job, const Digest& build) {
  if (JobEntry* entry = state_->live_job(job)) entry->build = build;
}

Actions Scheduler::cancel_job(JobId job, Instant now) {
  Actions actions;
  if (JobEntry* entry = state_->live_job(job)) {
    state_->end_job(*entry, JobEntry::State::cancelled, "the job was cancelled", actions);
  }
  state_->settle(now, actions);
  return actions;
}

Actions Scheduler::fail_job(JobId job, const std::string& reason, Instant now) {
  Actions actions;
  if (JobEntry* entry = state_->live_job(job)) state_->fail(*entry, reason, actions);
  state_->settle(now, actions);
  return actions;
}

Actions Scheduler::pause_job(JobId job, Instant now) {
  Actions actions;
  if (JobEntry* entry = state_->live_job(job)) entry->state = JobEntry::State::paused;
  state_->settle(now, actions);
  return actions;
}

Actions Scheduler::resume_job(JobId job, Instant now) {
  Actions actions;
  JobEntry* entry = state_->live_job(job);
  if (entry != nullptr && entry->state == JobEntry::State::paused) {
    entry->state = JobEntry::State::open;
    state_->level(*entry);
    state_->work_appeared = true;
  }
  state_->settle(now, actions);
  return actions;
}

Actions Scheduler::set_priority(JobId job, int priority, Instant now) {
  Actions actions;
  if (JobEntry* entry = state_->live_job(job)) {
    entry->priority = priority;
    state_->sort_order();
    state_->level(*entry);
  }
  state_->settle(now, actions);
  return actions;
}

Actions Scheduler::set_max_workers(JobId job, int max_workers, Instant now) {
  Actions actions;
  if (JobEntry* entry = state_->live_job(job)) {
    entry->max_workers = max_workers;
    state_->work_appeared = true;
  }
  state_->settle(now, actions);
  return actions;
}

Actions Scheduler::set_focus(JobId job, const std::optional<Rect>& focus, Instant now) {
  Actions actions;
  if (JobEntry* entry = state_->live_job(job)) {
    entry->tasks.set_focus(focus);
    state_->work_appeared = true;
  }
  state_->settle(now, actions);
  return actions;
}

void Scheduler::forget_job(JobId job) {
  const JobEntry* entry = state_->job(job);
  if (entry != nullptr && !entry->live()) state_->jobs.erase(job);
}

}  // namespace tessera::server
