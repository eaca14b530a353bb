// What the scheduler says is carried out, and held against its rules.
#include <fmt/format.h>

#include <algorithm>

#include "tests/sim/coordinator.hpp"
#include "tests/sim/worker.hpp"

namespace tessera::sim {

void Coordinator::arm() {
  const auto next = scheduler_->next_deadline();
  if (!next || (armed_ && *armed_ <= *next && *armed_ >= world_.events.now())) return;
  armed_ = next;
  world_.events.at(*next, [this, life = life_, instant = *next] {
    if (life != life_ || armed_ != instant) return;
    armed_.reset();
    apply(scheduler_->tick(world_.events.now()));
  });
}

void Coordinator::release(const LeaseId& lease) {
  const auto found = leases_.find(lease);
  if (found == leases_.end()) return;
  const std::pair task(found->second.job, found->second.task);
  const auto out = out_.find(task);
  out->second.erase(lease);
  if (out->second.empty()) out_.erase(out);
  doubted_.insert(task);
  held_[found->second.worker].erase(lease);
  leases_.erase(found);
}

void Coordinator::release_all(server::WorkerId worker) {
  for (const LeaseId& lease : std::set<LeaseId>(held_[worker])) release(lease);
  held_.erase(worker);
  idle_looks_.erase(worker);
  excused_.erase(worker);
}

void Coordinator::granted(const server::GrantLease& grant) {
  ++world_.decisions;
  world_.note(grant.lease.number ^ grant.task.tile ^ (std::uint64_t{grant.task.pass} << 20));
  const Disk::Job& job = world_.disk.jobs.at(grant.job);
  const std::string what = fmt::format("job {} {}", grant.job, text_of(grant.task));
  world_.tell("{} is granted to worker {}", what, grant.worker);
  const auto link = links_.find(grant.worker);
  require(link != links_.end(), what + " is granted to a worker that is connected");
  require(job.ended.empty() && !paused_.contains(grant.job), what + " is of a job that runs");
  require(job.plan->contains(grant.task), what + " is one of the job's");
  require(!job.results.contains(grant.task), what + " is not closed");
  const bool copied = out_.contains({grant.job, grant.task});
  if (copied) check_copy(grant, what);
  require(!arrived_.contains({grant.job, grant.task}),
          what + " is not granted while its result is being kept");
  require(grant.task.pass < offered(grant.job, grant.task.frame),
          what + " is of a pass that no look at its frame is waited for before");
  require(grant.task.pass < folded(grant.job, grant.task) + 3,
          what + " is within three passes of its tile's fold");
  if (!copied) check_focus(grant, what);
  check_time(grant, what);
  require(grant.lease.epoch == epoch_, what + " has a lease of this epoch");
  if (const auto build = builds_.find(grant.job); build != builds_.end()) {
    require(link->second->worker->info().build_id == build->second,
            what + " goes to the job's build");
  }
  require(leases_.emplace(grant.lease, Lease{grant.worker, grant.job, grant.task}).second,
          what + " has a lease of its own");
  out_[{grant.job, grant.task}].insert(grant.lease);
  held_[grant.worker].insert(grant.lease);
  if (const int most = job.plan->spec.max_workers; most > 0) {
    const auto holders = std::count_if(held_.begin(), held_.end(), [&](const auto& held) {
      return std::any_of(held.second.begin(), held.second.end(),
                         [&](const LeaseId& lease) { return leases_.at(lease).job == grant.job; });
    });
    require(holders <= most, what + " is held by as many workers as the job may have");
  }
  const Link to = link->second;
  const Assigned order{grant, plans_.at(grant.job)};
  world_.carry(to, false, [to, order] { to->worker->assigned(order); });
}

void Coordinator::check_focus(const server::GrantLease& grant, const std::string& what) const {
  const Disk::Job& job = world_.disk.jobs.at(grant.job);
  const auto focus = focus_.find(grant.job);
  // Of one whose time is limited not every pass is offered.
  if (focus == focus_.end() || !focus->second || job.plan->spec.time_limit_seconds > 0) return;
  const Rect& region = *focus->second;
  const auto in_focus = [&](std::uint32_t index) {
    const Rect pixel = job.plan->grid.tile(index);  // tiles are one pixel here
    return pixel.x >= region.x && pixel.x < region.x + region.width && pixel.y >= region.y &&
           pixel.y < region.y + region.height;
  };
  // Suspects are nobody's first choice, and go when there is somebody for them.
  if (in_focus(grant.task.tile) || doubted_.contains({grant.job, grant.task})) return;
  const auto sooner = waits(grant.job, true, [&](const TaskId& task) {
    return task.frame == grant.task.frame && in_focus(task.tile) &&
           (task.pass == 0 || grant.task.pass > 0);
  });
  require(!sooner,
          [&] { return what + " waits for the focus, of which is open " + text_of(*sooner); });
}

void Coordinator::check_time(const server::GrantLease& grant, const std::string& what) {
  const double now = world_.events.seconds_now();
  if (started_.emplace(grant.job, now).second) keep_started(grant.job);
  const double limit = world_.disk.jobs.at(grant.job).plan->spec.time_limit_seconds;
  if (limit == 0) return;
  std::uint32_t& begun = passes_begun_[grant.job];
  const bool late = now > started_.at(grant.job) + limit + 0.001;  // kept to the millisecond
  if (late && grant.task.pass >= std::max(begun, 1U)) {
    // It may have been offered in time, and have waited for folds; none is offered after it.
    require(late_.insert(grant.job).second, what + " is of a pass that was offered in time");
  }
  begun = std::max(begun, grant.task.pass + 1);
  const auto cut = shortened_.find(grant.job);
  const JobPlan& plan = *world_.disk.jobs.at(grant.job).plan;
  require(cut == shortened_.end() || plan.passes.pass(grant.task.pass).end() <= cut->second,
          what + " is of a pass that the job has");
}

void Coordinator::shortened(JobId id, std::int64_t samples) {
  const JobPlan& plan = *world_.disk.jobs.at(id).plan;
  require(plan.spec.time_limit_seconds > 0 || plan.spec.noise_threshold > 0,
          [&] { return fmt::format("job {} has a limit", id); });
  require(plan.spec.frames.count() == 1, [&] { return fmt::format("job {} has one frame", id); });
  bool whole = false;
  for (std::uint32_t pass = 0; pass < plan.passes.count(); ++pass)
    whole = whole || plan.passes.pass(pass).end() == samples;
  require(whole, [&] { return fmt::format("job {} ends at a whole pass", id); });
  const auto [known, fresh] = shortened_.emplace(id, samples);
  require(fresh || known->second == samples,
          [&] { return fmt::format("job {} is shortened in one way", id); });
  JobSpec spec = plan.spec;
  spec.render.samples = samples;
  plans_[id] = JobPlan(spec).digest;
}

void Coordinator::check_copy(const server::GrantLease& grant, const std::string& what) const {
  const std::set<LeaseId>& holders = out_.at({grant.job, grant.task});
  require(holders.size() < 3, what + " is out three times at most");
  const Worker& worker = *links_.at(grant.worker)->worker;
  for (const LeaseId& lease : holders) {
    const Worker& other = *links_.at(leases_.at(lease).worker)->worker;
    require(worker.info().identity != other.info().identity, what + " has one copy in a worker");
  }
  const auto held = held_.find(grant.worker);
  require(held == held_.end() || held->second.empty(), what + " is copied for an idle worker");
  for (const auto& [id, job] : world_.disk.jobs) {
    const auto view = scheduler_->job(id, world_.events.now());
    if (!view || (view->build && *view->build != worker.info().build_id)) continue;
    if (job.plan->spec.max_workers > 0 || job.plan->spec.time_limit_seconds > 0) continue;
    require(!waits(id, true), what + " is copied only where nothing is open");
  }
}

void Coordinator::apply(const server::Actions& actions) {
  for (const server::Action& action : actions) {
    if (const auto* grant = std::get_if<server::GrantLease>(&action)) {
      granted(*grant);
    } else if (const auto* revoke = std::get_if<server::RevokeLeases>(&action)) {
      for (const LeaseId& lease : revoke->leases) release(lease);
      const auto link = links_.find(revoke->worker);
      require(link != links_.end(), "leases are revoked from workers that are connected");
      const Link to = link->second;
      world_.carry(to, false, [to, leases = revoke->leases] { to->worker->revoked(leases); });
    } else if (const auto* drop = std::get_if<server::DropWorker>(&action)) {
      world_.note(drop->worker);
      const Link link = links_.at(drop->worker);
      links_.erase(drop->worker);
      release_all(drop->worker);
      link->open = false;
      world_.events.after(0.001, [link] { link->worker->disconnected(link); });
      later(world_.random.between(0, 1), [this, link] { left(link, false); });
    } else if (const auto* failed = std::get_if<server::JobFailed>(&action)) {
      world_.disk.jobs.at(failed->job).ended = "failed";
      throw Violation(fmt::format("job {} failed: {}", failed->job, failed->reason));
    } else if (const auto* frame = std::get_if<server::FrameFinished>(&action)) {
      later(0, [this, at = *frame] { write_frame(at.job, at.frame); });
    } else if (const auto* cut = std::get_if<server::JobShortened>(&action)) {
      shortened(cut->job, cut->samples);
    } else if (const auto* frame_cut = std::get_if<server::FrameShortened>(&action)) {
      shortened(*frame_cut);
    } else if (const auto* look = std::get_if<server::MeasureNoise>(&action)) {
      asked(*look);
    } else if (const auto* finished = std::get_if<server::JobFinished>(&action)) {
      require(world_.disk.jobs.at(finished->job).ended.empty() &&
                  finishing_.insert(finished->job).second,
              "a job is finished once");
      later(0, [this, job = finished->job] { finish(job); });
    }
  }
  arm();
}

std::optional<TaskId> Coordinator::waits(JobId id, bool plain,
                                         const std::function<bool(const TaskId&)>& such) const {
  const Disk::Job& job = world_.disk.jobs.at(id);
  if (!job.ended.empty() || paused_.contains(id) || !scheduler_->job(id, world_.events.now()))
    return std::nullopt;
  const FrameList& frames = job.plan->spec.frames;
  for (std::uint32_t index = 0; index < frames.count(); ++index) {
    const std::int32_t frame = frames.number(index);
    for (std::uint32_t tile = 0; tile < job.plan->grid.count(); ++tile) {
      TaskId task{frame, tile, folded(id, {frame, tile, 0})};
      const std::uint32_t end = std::min(task.pass + 3, offered(id, frame));
      for (; task.pass < end; ++task.pass) {
        if (such && !such(task)) continue;
        if (!job.results.contains(task) && !out_.contains({id, task}) &&
            !arrived_.contains({id, task}) && !(plain && doubted_.contains({id, task})))
          return task;
      }
    }
  }
  return std::nullopt;
}

bool Coordinator::quarantined(server::WorkerId worker) const {
  const auto views = scheduler_->workers(world_.events.now());
  return world_.weather.corrupt + world_.weather.error > 0 &&
         std::any_of(views.begin(), views.end(), [&](const server::WorkerView& view) {
           return view.id == worker && view.state == "quarantined";
         });
}

std::string Coordinator::describe(server::WorkerId worker,
                                  const std::vector<JobId>& waiting) const {
  std::string text;
  for (const server::WorkerView& view : scheduler_->workers(world_.events.now())) {
    if (view.id == worker)
      text = fmt::format("worker {} ({}) is {}", worker, view.info.name, view.state);
  }
  for (const JobId id : waiting) {
    const server::JobView view = *scheduler_->job(id, world_.events.now());
    text += fmt::format(", job {} is {} with {} of {} tasks done, {} leased, and {} waits", id,
                        view.state, view.tasks_done, view.tasks, view.leased,
                        text_of(*waits(id, false)));
  }
  return text;
}

void Coordinator::look_around() {
  if (!up()) return;
  const Instant now = world_.events.now();
  for (const auto& [worker, link] : links_) {
    if (world_.bug == Bug::forget_lost_worker && !link->open) scheduler_->worker_heard(worker, now);
    require(
        now - last_byte_[worker] < std::chrono::seconds(5) || world_.bug == Bug::forget_lost_worker,
        "a worker that was silent for five seconds is dropped");
    require(held_[worker].size() <= 1024, "a window has its most");
    require(link->open || held_[worker].empty() || now - link->cut_at < std::chrono::seconds(10),
            "no lease stays with a connection that is gone");
  }
  if (world_.bug != Bug::none && world_.bug != Bug::forget_lost_worker) return;
  std::vector<JobId> waiting;
  for (const auto& [id, job] : world_.disk.jobs) {
    // A job that may not have more workers has to wait for those that it has; one whose time is
    // limited, until another pass is offered.
    if (job.plan->spec.max_workers == 0 && job.plan->spec.time_limit_seconds == 0 &&
        waits(id, false))
      waiting.push_back(id);
  }
  for (const auto& [worker, link] : links_) {
    const auto& build = link->worker->info().build_id;
    const bool could = std::any_of(waiting.begin(), waiting.end(), [&](JobId id) {
      const auto view = scheduler_->job(id, now);
      return !view->build || *view->build == build;
    });
    const auto excused = excused_.find(worker);
    // It may still be at a scene that it was to build for leases that have ended since.
    const bool idle = held_[worker].empty() && !link->worker->prepares() &&
                      (excused == excused_.end() || excused->second < now);
    int& looks = idle_looks_[worker];
    looks = idle && could ? looks + 1 : 0;
    if (looks >= 3 && !quarantined(worker))
      throw Violation(
          fmt::format("no worker idles while a task waits: {}", describe(worker, waiting)));
  }
}

}  // namespace tessera::sim
