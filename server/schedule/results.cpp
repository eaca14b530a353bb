// Results: what is taken, and what a result that is durable changes.
#include <algorithm>

#include "server/schedule/state.hpp"

namespace tessera::server {

Verdict Scheduler::result_arrived(WorkerId worker, const LeaseId& lease, JobId job,
                                  const Digest& plan, const TaskId& task, Instant now) {
  state_->last_now = now;
  WorkerEntry* entry = state_->worker(worker);
  JobEntry* owner = state_->live_job(job);
  if (entry == nullptr) return Verdict::stale;
  entry->heard = now;
  if (owner == nullptr) return Verdict::stale;
  if (owner->earlier_plans.contains(plan)) return Verdict::stale;
  // Before its time was up it had more samples, and a start knows of these no more.
  if (plan != owner->plan().digest && (owner->limited() || owner->watched()) &&
      state_->numbers.granted(lease, entry->info.identity, job, task))
    return Verdict::stale;
  if (plan != owner->plan().digest || !owner->plan().contains(task) ||
      !state_->numbers.granted(lease, entry->info.identity, job, task)) {
    state_->offend(*entry);
    return Verdict::rejected;
  }
  const auto held = entry->leases.find(lease.number);
  if (held != entry->leases.end() && held->second.id == lease) {
    const double took = seconds(now - entry->busy_since);
    const HeldLease ended = state_->end_lease(*entry, lease.number);
    WorkerEntry::Part& part = entry->parts[job];
    part.ready = true;
    part.speed.add(static_cast<double>(ended.samples), took);
    part.power.add(owner->left.cost(task.tile) * static_cast<double>(ended.samples), took);
    if (part.power.known())
      owner->left.measured(task.tile, ended.samples, took * part.power.rate());
    owner->pace.add(static_cast<double>(ended.samples), took * std::max(1, entry->info.threads));
    entry->measured(now);
  }
  entry->gets_on(now);
  entry->expired.clear();
  state_->touched.insert(worker);

  if (!owner->takes(entry->info.build_id)) return Verdict::stale;
  if (owner->journaling.contains(task)) return Verdict::stale;
  const Charges* charges = owner->blame.find(task);
  if (charges != nullptr && charges->invalid.contains(lease)) return Verdict::stale;
  switch (owner->tasks.state(task)) {
    case TaskTable::State::closed:
      return Verdict::stale;
    case TaskTable::State::open:
      if (task.pass >= owner->tasks.passes(task.frame)) return Verdict::stale;  // cut before it
      if (!owner->tasks.take(task)) return Verdict::stale;
      // Granted in an earlier epoch: a pass that has begun is finished for every tile.
      if (task.pass >= owner->tasks.offered(task.frame)) {
        state_->offer(*owner, task.frame, task.pass + 1);
        state_->work_appeared = true;
      }
      break;
    case TaskTable::State::taken:
      owner->blame.taken(task);
      break;
  }
  owner->journaling.emplace(task, lease);
  if (!owner->build) owner->build = entry->info.build_id;
  return Verdict::take;
}

void Scheduler::State::finished(JobEntry& job, std::int32_t frame, TaskTable::Folded what,
                                Actions& actions) {
  if (what != TaskTable::Folded::frame && what != TaskTable::Folded::job) return;
  job.looks.erase(frame);
  if (job.tasks.is_cut(frame)) {
    const std::int64_t samples = job.tasks.frame_samples(frame);
    if (job.plan().spec.frames.count() == 1) {
      actions.emplace_back(JobShortened{job.id, samples});
    } else {
      actions.emplace_back(FrameShortened{job.id, frame, samples});
    }
  }
  actions.emplace_back(FrameFinished{job.id, frame});
  if (what != TaskTable::Folded::job) return;
  end_job(job, JobEntry::State::done, "the job is done", actions);
  actions.emplace_back(JobFinished{job.id});
}

void Scheduler::State::stop_others(JobEntry& job, const TaskId& task, Instant now,
                                   Actions& actions) {
  for (const Holder& holder : std::vector(job.out.holders(task))) {
    actions.emplace_back(
        RevokeLeases{holder.worker, {holder.lease}, "its result has come from elsewhere"});
    WorkerEntry& loser = *worker(holder.worker);
    const auto& [first, running] = *loser.leases.begin();
    if (first == holder.lease.number) {
      // It was no faster than this. What it has done of it does not count for its next task.
      const double took = seconds(now - loser.busy_since);
      const double whole = static_cast<double>(running.samples);
      const double done = running.fraction > 0 ? running.fraction * whole : whole;
      if (done < speed_of(loser, job) * took) loser.parts[job.id].speed.add(done, took);
      loser.measured(now);
    }
    end_lease(loser, holder.lease.number);
  }
}

Actions Scheduler::result_invalid(WorkerId worker, const LeaseId& lease, JobId job,
                                  const TaskId& task, const std::string& reason, Instant now) {
  Actions actions;
  JobEntry* owner = state_->live_job(job);
  WorkerEntry* entry = state_->worker(worker);
  if (owner != nullptr) {
    const auto journaled = owner->journaling.find(task);
    if (journaled != owner->journaling.end() && journaled->second == lease) {
      owner->journaling.erase(journaled);
      if (reason.empty() || entry == nullptr) {
        state_->put_back(*owner, task);
      } else {
        owner->blame.charge(task).invalid.insert(lease);
        state_->error_said(*owner, task, entry->info.identity, "an invalid result: " + reason,
                           actions);
      }
    }
  }
  if (!reason.empty() && entry != nullptr) {
    actions.emplace_back(AttemptFailed{job, task, lease, worker, entry->info.name,
                                       AttemptFailed::Outcome::invalid, reason, std::nullopt});
    state_->rest(*entry, now);
    state_->fault_of(*entry, job, "an invalid result: " + reason);
    state_->offend(*entry);
  }
  state_->settle(now, actions);
  return actions;
}

Actions Scheduler::result_durable(WorkerId worker, const LeaseId& lease, JobId job,
                                  const TaskId& task, std::int64_t samples, double took,
                                  Instant now) {
  static_cast<void>(took);
  Actions actions;
  if (WorkerEntry* entry = state_->worker(worker)) {
    ++entry->tasks_done;
    entry->errors_in_row = 0;
    state_->identities[entry->info.identity].failures.clear();
  }
  JobEntry* owner = state_->live_job(job);
  if (owner != nullptr) {
    const auto journaled = owner->journaling.find(task);
    if (journaled != owner->journaling.end() && journaled->second == lease) {
      owner->journaling.erase(journaled);
      if (owner->tasks.close(task)) owner->left.closed(task.tile, owner->tasks.samples(task));
      owner->blame.clear(task);
      owner->progress.add(static_cast<double>(samples), seconds(now - owner->progress_mark));
      owner->progress_mark = now;
      state_->stop_others(*owner, task, now, actions);
    }
  }
  state_->settle(now, actions);
  return actions;
}

Actions Scheduler::tile_folded(JobId job, std::int32_t frame, std::uint32_t tile,
                               std::uint32_t passes, Instant now) {
  Actions actions;
  JobEntry* owner = state_->live_job(job);
  if (owner == nullptr || !owner->plan().contains({frame, tile, 0})) return actions;
  passes = std::min(passes, owner->tasks.passes(frame));
  if (passes > owner->tasks.offered(frame)) state_->offer(*owner, frame, passes);
  const std::int64_t before = owner->tasks.samples_closed();
  const TaskTable::Folded finished = owner->tasks.fold(frame, tile, passes);
  // From what is older than the journal.
  const std::int64_t closed = owner->tasks.samples_closed() - before;
  if (closed > 0) owner->left.closed(tile, closed);
  if (finished != TaskTable::Folded::nothing) state_->work_appeared = true;
  state_->finished(*owner, frame, finished, actions);
  if (finished == TaskTable::Folded::tile) state_->ask_for_look(*owner, frame, actions);
  state_->settle(now, actions);
  return actions;
}

}  // namespace tessera::server
