// The tail: copies of late tasks for workers that would idle.
#include <algorithm>

#include "server/schedule/state.hpp"

namespace tessera::server {
namespace {

/// So many tasks are looked at for one worker: the cost of a decision has a bound.
constexpr int looks_most = 32;
/// So many idle workers are asked at each look around.
constexpr std::size_t asked_most = 64;
constexpr Duration look_every = std::chrono::milliseconds(250);
/// A copy must be expected to be done in so much less time than the attempts that are out, for it
/// may be mistaken, and it costs what it costs.
constexpr double gain_least = 1.25;

Duration from_seconds(double value) {
  constexpr double most = 1e9;
  return std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(std::clamp(value, 0.0, most)));
}

/// What is late already is expected to take as long again as it is late.
Instant not_before(Instant end, Instant now) { return end > now ? end : now + (now - end); }

}  // namespace

double Scheduler::State::speed_of(const WorkerEntry& worker, const JobEntry& job) const {
  const auto part = worker.parts.find(job.id);
  const double by_others = job.pace.rate() * std::max(1, worker.info.threads);
  if (part == worker.parts.end()) return by_others;
  Meter speed = part->second.speed;
  double done = 0;  // of what runs, since it was measured
  for (const auto& [number, held] : worker.leases) {
    if (held.fraction == 0) break;  // they are begun in this order
    if (held.job == job.id)
      done += (held.fraction - held.counted) * static_cast<double>(held.samples);
  }
  if (done > 0 && worker.reported > worker.busy_since)
    speed.add(done, seconds(worker.reported - worker.busy_since));
  return speed.known() ? speed.rate() : by_others;
}

Instant Scheduler::State::expected_end(const JobEntry& job, const Holder& holder, Instant now) {
  WorkerEntry& holding = *worker(holder.worker);
  double ahead = 0;  // seconds, to the end of this lease
  const JobEntry* of = nullptr;
  double speed = 0;
  for (const auto& [number, held] : holding.leases) {
    if (of == nullptr || of->id != held.job) {
      of = this->job(held.job);
      speed = of == nullptr ? 0 : speed_of(holding, *of);
    }
    if (speed <= 0) return TasksOut::unknown;
    ahead += static_cast<double>(held.samples) / speed;
    if (held.id == holder.lease) break;
  }
  const auto part = holding.parts.find(job.id);
  if (part != holding.parts.end() && !part->second.ready) ahead += job.preparation_seconds;
  return not_before(holding.busy_since + from_seconds(ahead), now);
}

Instant Scheduler::State::expected_end(const JobEntry& job, const TaskId& task, Instant now) {
  Instant first = TasksOut::unknown;
  for (const Holder& holder : job.out.holders(task))
    first = std::min(first, expected_end(job, holder, now));
  return first;
}

bool Scheduler::State::worth_a_copy(const JobEntry& job, const TaskId& task, Instant end,
                                    const WorkerEntry& idle, Instant now) {
  const std::vector<Holder>& holders = job.out.holders(task);
  const bool holds_it = std::any_of(holders.begin(), holders.end(), [&](const Holder& holder) {
    return worker(holder.worker)->info.identity == idle.info.identity;
  });
  if (holds_it || job.journaling.contains(task)) return false;
  const double speed = speed_of(idle, job);
  if (speed <= 0 || end == TasksOut::unknown) return false;
  double fresh = static_cast<double>(job.tasks.samples(task)) / speed;
  const auto part = idle.parts.find(job.id);
  if (part == idle.parts.end() || !part->second.ready) fresh += job.preparation_seconds;
  return now + from_seconds(gain_least * fresh) < end;
}

std::optional<TaskId> Scheduler::State::late_task(JobEntry& job, const WorkerEntry& idle,
                                                  Instant now) {
  TasksOut& out = job.out;
  int looks = 0;
  // What should have come by now, and has not, moves to where it is expected at present.
  while (!out.by_end().empty() && out.by_end().begin()->first <= now && ++looks < looks_most / 2) {
    const TaskId task = out.by_end().begin()->second;
    out.expect(task, expected_end(job, task, now));
  }
  auto place = out.by_end().rbegin();
  while (place != out.by_end().rend() && ++looks < looks_most) {
    const auto [told, task] = *place;
    if (job.blame.suspect(task) ||
        out.holders(task).size() >= static_cast<std::size_t>(settings.copies_most)) {
      out.unlist(task);
      place = out.by_end().rbegin();
      continue;
    }
    const Instant end = expected_end(job, task, now);
    if (end < told && std::next(place) != out.by_end().rend() && end < std::next(place)->first) {
      out.expect(task, end);  // sooner than was thought: another comes first
      place = out.by_end().rbegin();
      continue;
    }
    if (worth_a_copy(job, task, end, idle, now)) return task;
    ++place;
  }
  return std::nullopt;
}

bool Scheduler::State::grant_copy(WorkerEntry& idle, Instant now, Actions& actions) {
  if (settings.copies_most < 2 || !idle.leases.empty() || !idle.has_room(settings)) return false;
  for (JobEntry* job : order) {
    if (job->out.by_end().empty() || !job->has_place_for(idle.id) || !eligible(*job, idle))
      continue;
    if (const auto task = late_task(*job, idle, now)) {
      grant(idle, *job, *task, false, now, actions);
      return true;
    }
  }
  return false;
}

void Scheduler::State::look_at_tail(Instant now, Actions& actions) {
  tail_look.reset();
  auto place = idlers.upper_bound(last_asked);
  const auto asked_now = std::min(asked_most, idlers.size());
  for (std::size_t asked = 0; asked < asked_now && !idlers.empty(); ++asked) {
    if (place == idlers.end()) place = idlers.begin();
    last_asked = *place;
    WorkerEntry& entry = *worker(*place++);
    grant_copy(entry, now, actions);
  }
}

void Scheduler::State::plan_tail_look(Instant now) {
  if (idlers.empty() || order.empty() || settings.copies_most < 2) {
    tail_look.reset();
  } else if (!tail_look) {
    tail_look = now + look_every;
  }
}

}  // namespace tessera::server
