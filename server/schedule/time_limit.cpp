// Jobs whose time is limited end at a whole pass of every tile.
#include <algorithm>

#include "server/schedule/state.hpp"

namespace tessera::server {
namespace {

/// Every task of the passes offered so far is in somebody's hands, or done. (That there is none to
/// hand out just now says less: later passes wait for folds.)
bool all_handed_out(const JobEntry& job) {
  const auto offered = std::int64_t{job.plan().grid.count()} * job.tasks.offered(job.only_frame()) -
                       job.tasks.closed();
  const std::size_t in_hand = job.out.size() + job.journaling.size() + job.blame.waiting().size();
  if (static_cast<std::int64_t>(in_hand) < offered) return false;
  // A task whose result is being kept may be out as a copy, too.
  const auto twice = std::count_if(job.journaling.begin(), job.journaling.end(),
                                   [&](const auto& kept) { return job.out.contains(kept.first); });
  return static_cast<std::int64_t>(in_hand) - twice >= offered;
}

/// Seconds that the next pass takes if it gets on as all before it did, standstills included: for
/// when nobody who was measured is at it.
double taken_at_the_pace_so_far(const JobEntry& job, Instant now) {
  const auto done = static_cast<double>(job.tasks.samples_closed());
  if (done == 0) return 0;
  const auto pixels = static_cast<double>(job.plan().grid.window().pixels());
  const std::uint32_t offered = job.tasks.offered(job.only_frame());
  const auto next = static_cast<double>(job.plan().passes.pass(offered).count);
  return (job.plan().spec.time_limit_seconds - job.time_left(now)) * pixels * next / done;
}

}  // namespace

std::optional<bool> Scheduler::State::in_time(const JobEntry& job, Instant now) const {
  const double left = job.time_left(now);
  if (left <= 0) return false;
  const auto pace = pace_of(job, job.tasks.offered(job.only_frame()) + 1, now);
  if (!pace && !job.out.empty()) return std::nullopt;
  if (!pace) return taken_at_the_pace_so_far(job, now) <= left;
  // Nine times in ten it will not take longer.
  return time_to_finish(*pace).high <= left;
}

void Scheduler::State::cut(JobEntry& job, std::int32_t frame, Actions& actions) {
  const PassPlan& plan = job.plan().passes;
  const std::uint32_t offered = job.tasks.offered(frame);
  job.left.cut(plan.samples() - plan.pass(offered - 1).end());
  limited.erase(job.id);
  const TaskTable::Folded what = job.tasks.cut(frame, offered);
  finished(job, frame, what, actions);
}

bool Scheduler::State::offer_passes(Instant now, Actions& actions) {
  bool offered = false;
  const std::set<JobId> asked = limited;
  for (const JobId id : asked) {
    JobEntry* entry = live_job(id);
    if (entry == nullptr || entry->state != JobEntry::State::open ||
        awaits_look(*entry, entry->only_frame()) || !all_handed_out(*entry))
      continue;
    const std::int32_t frame = entry->only_frame();
    const std::uint32_t passes = entry->tasks.offered(frame);
    if (passes == entry->tasks.passes()) {
      limited.erase(id);  // all that was asked for is in time
      continue;
    }
    const std::optional<bool> good = in_time(*entry, now);
    if (!good) continue;  // a first result will tell
    if (*good) {
      offer(*entry, frame, passes + 1);
      offered = work_appeared = true;
    } else {
      cut(*entry, frame, actions);
    }
  }
  return offered;
}

}  // namespace tessera::server
