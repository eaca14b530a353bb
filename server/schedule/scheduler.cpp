// Time, and what can be seen.
#include "server/schedule/scheduler.hpp"

#include <algorithm>

#include "server/schedule/state.hpp"

namespace tessera::server {

Scheduler::Scheduler(SchedulerSettings settings) : state_(std::make_unique<State>(settings)) {}
Scheduler::~Scheduler() = default;

Actions Scheduler::tick(Instant now) {
  Actions actions;
  State& state = *state_;
  while (const auto entry = state.timers.pop(now)) {
    WorkerEntry* worker = state.worker(entry->second);
    if (worker == nullptr || worker->timer != entry->first) continue;
    worker->timer.reset();
    if (worker->heard + state.settings.silence <= now) {
      state.drop(*worker, true, "nothing was heard of it for too long", now, actions);
      continue;
    }
    if (worker->rests && *worker->rests <= now) {
      worker->rests.reset();
      state.touched.insert(worker->id);
    }
    if (worker->hung && worker->leases.empty() &&
        worker->got_on + state.settings.preparation <= now)
      state.still_hangs(*worker, now, actions);
    if (!worker->leases.empty() && worker->next_stall(state.settings) <= now)
      state.expire(*worker, now, actions);
    state.timers.arm(*worker, worker->due(state.settings));
  }
  if (state.tail_look && *state.tail_look <= now) state.look_at_tail(now, actions);
  state.settle(now, actions);
  return actions;
}

std::optional<Instant> Scheduler::next_deadline() const {
  if (!state_->touched.empty()) return state_->last_now;
  const std::optional<Instant> next = state_->timers.next();
  return next && state_->tail_look ? std::min(*next, *state_->tail_look) : next;
}

namespace {

std::string state_of(const WorkerEntry& worker) {
  if (worker.barred) return "quarantined";
  if (worker.draining) return "draining";
  if (worker.stalled()) return "stalled";
  if (worker.leases.empty()) return "idle";
  const bool rendering =
      std::any_of(worker.leases.begin(), worker.leases.end(), [&](const auto& lease) {
        const auto part = worker.parts.find(lease.second.job);
        return part != worker.parts.end() && part->second.ready;
      });
  return rendering ? "rendering" : "preparing";
}

std::string state_of(const JobEntry& job) {
  switch (job.state) {
    case JobEntry::State::open:
      return job.granted || job.tasks.closed() > 0 ? "rendering" : "queued";
    case JobEntry::State::paused:
      return "paused";
    case JobEntry::State::failed:
      return "failed";
    case JobEntry::State::cancelled:
      return "cancelled";
    case JobEntry::State::done:
      break;
  }
  return "done";
}

JobView view_of(const JobEntry& job, std::string waiting_for, const std::optional<Pace>& pace,
                Instant now) {
  JobView view;
  view.id = job.id;
  view.state = state_of(job);
  view.tasks = job.tasks.tasks();
  view.tasks_done = job.tasks.closed();
  view.leased = static_cast<std::int64_t>(job.out.size());
  view.samples = job.tasks.samples();
  view.samples_done = job.tasks.samples_closed();
  view.error = job.error;
  view.waiting_for = std::move(waiting_for);
  view.priority = job.priority;
  view.build = job.build;
  if (job.state == JobEntry::State::open && job.progress.known()) {
    view.samples_per_second = job.progress.rate(seconds(now - job.progress_mark));
    if (pace) {
      TimeToFinish time = time_to_finish(*pace);
      if (job.limited() &&
          !job.tasks.is_cut(job.only_frame())) {  // it ends when its time is up, or before
        const double most = std::max(0.0, job.time_left(now));
        for (double* value : {&time.expected, &time.low, &time.high})
          *value = std::min(*value, most);
      }
      view.eta_seconds = time.expected;
      view.eta_low_seconds = time.low;
      view.eta_high_seconds = time.high;
    }
  }
  return view;
}

}  // namespace

std::vector<WorkerView> Scheduler::workers(Instant now) const {
  std::vector<WorkerView> views;
  views.reserve(state_->workers.size());
  for (const auto& [id, worker] : state_->workers) {
    double speed = 0;
    for (const auto& [job, part] : worker.parts) {
      if (part.samples_held > 0) speed = std::max(speed, part.speed.rate());
    }
    const auto barred = state_->quarantines.find(worker.info.name);
    views.push_back({id, worker.info, state_of(worker),
                     barred == state_->quarantines.end() ? std::string() : barred->second,
                     worker.leases.size(), worker.tasks_done, speed, seconds(now - worker.heard)});
  }
  return views;
}

std::optional<JobView> Scheduler::job(JobId job, Instant now) const {
  const JobEntry* entry = state_->job(job);
  if (entry == nullptr) return std::nullopt;
  return view_of(*entry, state_->waiting_for(*entry), state_->pace_of(*entry, now), now);
}

std::vector<JobView> Scheduler::jobs(Instant now) const {
  std::vector<JobView> views;
  views.reserve(state_->jobs.size());
  for (const auto& [id, entry] : state_->jobs)
    views.push_back(view_of(entry, state_->waiting_for(entry), state_->pace_of(entry, now), now));
  return views;
}

}  // namespace tessera::server
