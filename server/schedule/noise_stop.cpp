// Jobs that end when their frame's noise is low enough. What is looked at is the film of whole
// passes of every tile, at passes that the plan tells, and no pass beyond is begun before: so when
// such a job ends depends on its samples alone.
#include "server/schedule/noise_stop.hpp"

#include "server/schedule/state.hpp"

namespace tessera::server {

bool noise_is_looked_at(const PassPlan& plan, std::uint32_t passes) {
  return passes == next_look(plan, passes);
}

std::uint32_t next_look(const PassPlan& plan, std::uint32_t passes) {
  constexpr std::int64_t first = 16;  // fewer samples say little of their own error
  std::int64_t looked = 0;
  for (std::uint32_t count = 1; count < plan.count(); ++count) {
    const std::int64_t end = plan.pass(count - 1).end();
    // Each look waits for the last task, so that there is one for an eighth more samples.
    if (end < first || end * 8 < looked * 9) continue;
    looked = end;
    if (count >= passes) return count;
  }
  return plan.count();
}

void Scheduler::State::offer(JobEntry& job, std::uint32_t passes) {
  const bool ahead = job.watched() && !job.limited();
  job.tasks.offer_passes(ahead ? next_look(job.plan().passes, passes) : passes);
}

bool Scheduler::State::awaits_look(const JobEntry& job) const {
  const std::uint32_t offered = job.tasks.offered();
  return job.watched() && job.looked_at < offered && offered < job.tasks.passes() &&
         noise_is_looked_at(job.plan().passes, offered);
}

void Scheduler::State::ask_for_look(JobEntry& job, Actions& actions) {
  const std::uint32_t offered = job.tasks.offered();
  if (!job.watched() || job.look_asked >= offered || !job.tasks.all_folded(offered)) return;
  if (!awaits_look(job)) return;
  job.look_asked = offered;
  actions.emplace_back(MeasureNoise{job.id, job.plan().spec.frames.first(), offered});
}

Actions Scheduler::noise_measured(JobId job, std::uint32_t passes, double noise, Instant now) {
  Actions actions;
  JobEntry* owner = state_->live_job(job);
  if (owner == nullptr || passes != owner->tasks.offered() || !state_->awaits_look(*owner))
    return actions;
  if (noise <= owner->plan().spec.noise_threshold) {
    state_->cut(*owner, actions);
  } else {
    owner->looked_at = passes;
    // Where time is limited too, another pass is offered if it is over in time.
    if (!owner->limited()) {
      state_->offer(*owner, passes + 1);
      state_->work_appeared = true;
    }
  }
  state_->settle(now, actions);
  return actions;
}

}  // namespace tessera::server
