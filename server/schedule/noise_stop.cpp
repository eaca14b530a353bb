// Frames that end when their noise is low enough. What is looked at is the film of whole passes of
// every tile, at passes that the plan tells, and no pass of the frame beyond is begun before: so
// when a frame ends depends on its samples alone, and not on the job's other frames.
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

std::uint32_t passes_within(const PassPlan& plan, std::int64_t samples) {
  std::uint32_t within = 0, beyond = plan.count();
  while (within < beyond) {
    const std::uint32_t middle = within + (beyond - within) / 2;
    if (plan.pass(middle).end() <= samples) {
      within = middle + 1;
    } else {
      beyond = middle;
    }
  }
  return within;
}

void Scheduler::State::offer_first(JobEntry& job, std::uint32_t passes) {
  const bool ahead = job.watched() && !job.limited();
  job.tasks.offer_first(ahead ? next_look(job.plan().passes, passes) : passes);
}

void Scheduler::State::offer(JobEntry& job, std::int32_t frame, std::uint32_t passes) {
  const bool ahead = job.watched() && !job.limited();
  job.tasks.offer_passes(frame, ahead ? next_look(job.plan().passes, passes) : passes);
}

bool Scheduler::State::awaits_look(const JobEntry& job, std::int32_t frame) const {
  const std::uint32_t offered = job.tasks.offered(frame);
  const auto look = job.looks.find(frame);
  return job.watched() && (look == job.looks.end() || look->second.too_high < offered) &&
         offered < job.tasks.passes(frame) && noise_is_looked_at(job.plan().passes, offered);
}

void Scheduler::State::ask_for_look(JobEntry& job, std::int32_t frame, Actions& actions) {
  const std::uint32_t offered = job.tasks.offered(frame);
  if (!job.watched() || !job.tasks.all_folded(frame, offered) || !awaits_look(job, frame)) return;
  std::uint32_t& asked = job.looks[frame].asked;
  if (asked >= offered) return;
  asked = offered;
  actions.emplace_back(MeasureNoise{job.id, frame, offered});
}

Actions Scheduler::noise_measured(JobId job, std::int32_t frame, std::uint32_t passes, double noise,
                                  Instant now) {
  Actions actions;
  JobEntry* owner = state_->live_job(job);
  if (owner == nullptr || !owner->plan().spec.frames.contains(frame) ||
      passes != owner->tasks.offered(frame) || !state_->awaits_look(*owner, frame) ||
      !owner->tasks.all_folded(frame, passes))
    return actions;
  const double threshold = owner->plan().spec.noise_threshold;
  if (noise <= threshold) {
    state_->cut(*owner, frame, actions);
  } else {
    owner->looks[frame].too_high = passes;
    // It falls with the root of their number.
    const auto samples = static_cast<double>(owner->plan().passes.pass(passes - 1).end());
    owner->tasks.expect(frame, samples * (noise / threshold) * (noise / threshold));
    // Where time is limited too, another pass is offered if it is over in time.
    if (!owner->limited()) {
      state_->offer(*owner, frame, passes + 1);
      state_->work_appeared = true;
    }
  }
  state_->settle(now, actions);
  return actions;
}

}  // namespace tessera::server
