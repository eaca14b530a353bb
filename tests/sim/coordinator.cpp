#include "tests/sim/coordinator.hpp"

#include <fmt/format.h>

#include <utility>

#include "tests/sim/synthetic.hpp"
#include "tests/sim/worker.hpp"

namespace tessera::sim {

using server::Actions;

void Coordinator::later(double delay, std::function<void()> what) {
  world_.events.after(delay, [this, life = life_, what = std::move(what)] {
    if (life == life_) what();
  });
}

void Coordinator::start() {
  server::SchedulerSettings settings;
  settings.epoch = ++world_.disk.epoch;
  settings.grant_key = {1, 2, 3};
  settings.deaths_alone = 1'000'000;  // crashes come at random here, and no task is to blame
  scheduler_ = std::make_unique<server::Scheduler>(settings);
  for (const auto& [id, job] : world_.disk.jobs) {
    if (job.ended.empty()) restore(id);
  }
}

void Coordinator::restore(JobId id) {
  const Disk::Job& job = world_.disk.jobs.at(id);
  apply(scheduler_->add_job(id, job.plan, world_.events.now()));
  std::set<std::pair<std::int32_t, std::uint32_t>> tiles;
  for (const auto& [task, tile] : job.results) {
    scheduler_->restore_closed(id, task);
    tiles.emplace(task.frame, task.tile);
  }
  if (!job.results.empty() && builds_.contains(id)) scheduler_->restore_build(id, builds_[id]);
  for (const auto& [frame, tile] : tiles) {
    later(world_.random.between(0, 2),
          [this, id, frame = frame, tile = tile] { fold_on(id, frame, tile); });
  }
}

void Coordinator::kill() {
  ++life_;
  scheduler_.reset();
  armed_.reset();
  links_.clear();
  for (const auto& worker : world_.workers) {
    if (const Link link = worker->link()) world_.cut(link, false);
  }
  last_byte_.clear();
  held_.clear();
  idle_looks_.clear();
  excused_.clear();
  leases_.clear();
  out_.clear();
  doubted_.clear();
  arrived_.clear();
  films_.clear();
  paused_.clear();
  journal_.clear();
  syncing_ = false;
}

void Coordinator::submit(JobId job) {
  if (up()) apply(scheduler_->add_job(job, world_.disk.jobs.at(job).plan, world_.events.now()));
}

void Coordinator::cancel(JobId job) {
  Disk::Job& kept = world_.disk.jobs.at(job);
  if (!up() || !kept.ended.empty()) return;
  kept.ended = "cancelled";
  apply(scheduler_->cancel_job(job, world_.events.now()));
}

void Coordinator::pause(JobId job, double duration) {
  if (!up() || !world_.disk.jobs.at(job).ended.empty()) return;
  paused_.insert(job);
  apply(scheduler_->pause_job(job, world_.events.now()));
  later(duration, [this, job] {
    paused_.erase(job);
    apply(scheduler_->resume_job(job, world_.events.now()));
  });
}

bool Coordinator::all_ended() const {
  return std::all_of(world_.disk.jobs.begin(), world_.disk.jobs.end(),
                     [](const auto& job) { return !job.second.ended.empty(); });
}

bool Coordinator::heard(const Link& link) {
  if (!up() || link->life != life_ || link->left) return false;
  last_byte_[link->known_as] = world_.events.now();
  scheduler_->worker_heard(link->known_as, world_.events.now());
  return true;
}

void Coordinator::hello(const Link& link, const server::WorkerInfo& info) {
  if (!up()) {
    world_.cut(link, false);
    return;
  }
  const auto joined = scheduler_->worker_joined(info, world_.events.now());
  require(!links_.contains(joined.worker), "a connection that has not ended keeps its worker's id");
  link->known_as = joined.worker;
  link->life = life_;
  links_[joined.worker] = link;
  last_byte_[joined.worker] = world_.events.now();
  apply(joined.actions);
}

void Coordinator::preparing(const Link& link, JobId job) {
  if (!heard(link)) return;
  apply(scheduler_->worker_preparing(link->known_as, job, 0, world_.events.now()));
}

void Coordinator::ready(const Link& link, JobId job) {
  if (!heard(link)) return;
  apply(scheduler_->worker_ready(link->known_as, job, world_.events.now()));
}

void Coordinator::progress(const Link& link,
                           const std::vector<std::pair<LeaseId, double>>& running) {
  if (!heard(link)) return;
  apply(scheduler_->worker_progress(link->known_as, running, world_.events.now()));
}

void Coordinator::failed(const Link& link, JobId job, const LeaseId& lease) {
  if (!heard(link)) return;
  release(lease);
  excused_[link->known_as] = world_.events.now() + from_seconds(80);
  apply(scheduler_->worker_failed(link->known_as, job, lease, "an error", world_.events.now()));
}

void Coordinator::left(const Link& link, bool clean) {
  if (!up() || link->known_as == 0 || link->life != life_ || std::exchange(link->left, true))
    return;
  const auto known = links_.find(link->known_as);
  if (known != links_.end() && known->second == link) links_.erase(known);
  release_all(link->known_as);
  apply(scheduler_->worker_left(link->known_as, clean, world_.events.now()));
}

void Coordinator::bye(const Link& link) { left(link, true); }

void Coordinator::closed(const Link& link) {
  if (world_.bug != Bug::forget_lost_worker) left(link, false);
}

void Coordinator::result(const Link& link, const SentResult& sent) {
  if (!heard(link)) return;
  const Disk::Job& job = world_.disk.jobs.at(sent.job);
  auto verdict = scheduler_->result_arrived(link->known_as, sent.lease, sent.job, job.plan->digest,
                                            sent.task, world_.events.now());
  require(verdict != server::Verdict::rejected,
          "a lease that was granted to this identity is known again");
  release(sent.lease);
  if (verdict == server::Verdict::take) doubted_.erase({sent.job, sent.task});
  world_.note(static_cast<std::uint64_t>(verdict));
  if (world_.bug == Bug::keep_without_asking) verdict = server::Verdict::take;
  if (verdict == server::Verdict::stale) {
    world_.carry(link, false, [this, link, lease = sent.lease] { link->worker->answered(lease); });
  } else {
    require(world_.bug != Bug::none || !job.results.contains(sent.task),
            "a closed task's result is stale");
    arrived_.emplace(sent.job, sent.task);
    if (sent.corrupt) doubted_.emplace(sent.job, sent.task);
    const Arrived arrived{link, link->known_as, sent};
    later(world_.random.between(0, 0.01), [this, arrived] {
      if (arrived.sent.corrupt) {
        arrived_.erase({arrived.sent.job, arrived.sent.task});
        excused_[arrived.worker] = world_.events.now() + from_seconds(80);
        world_.carry(arrived.link, false,
                     [arrived] { arrived.link->worker->answered(arrived.sent.lease); });
        apply(scheduler_->result_invalid(arrived.worker, arrived.sent.lease, arrived.sent.job,
                                         arrived.sent.task, "no tile", world_.events.now()));
        return;
      }
      journal_.push_back(arrived);
      commit();
    });
  }
  arm();
}

void Coordinator::commit() {
  if (syncing_ || journal_.empty()) return;
  syncing_ = true;
  std::vector<Arrived> group = std::exchange(journal_, {});
  if (world_.bug == Bug::acknowledge_before_commit) {
    for (const Arrived& arrived : group)
      world_.acknowledged.emplace(arrived.sent.job, arrived.sent.task);
  }
  later(world_.random.between(0.001, world_.weather.sync_most), [this, group] {
    // The instant of the commit: from here on it survives.
    for (const Arrived& arrived : group) {
      const Disk::Job& job = world_.disk.jobs.at(arrived.sent.job);
      if (job.ended.empty()) {
        world_.disk.keep(
            arrived.sent.job, arrived.sent.task,
            std::make_shared<const image::TileImage>(render(*job.plan, arrived.sent.task)));
        builds_.emplace(arrived.sent.job, arrived.link->worker->info().build_id);
      }
    }
    // A kill may come between the commit and what follows from it.
    later(world_.random.between(0, 0.002), [this, group] {
      for (const Arrived& arrived : group) durable(arrived);
      syncing_ = false;
      commit();
    });
  });
}

void Coordinator::durable(const Arrived& arrived) {
  const auto& [link, worker, sent] = arrived;
  arrived_.erase({sent.job, sent.task});
  if (world_.disk.jobs.at(sent.job).results.contains(sent.task)) {
    world_.acknowledged.emplace(sent.job, sent.task);
    const Link to = link;
    const LeaseId lease = sent.lease;
    world_.carry(to, false, [to, lease] { to->worker->answered(lease); });
  }
  const JobPlan& plan = *world_.disk.jobs.at(sent.job).plan;
  apply(scheduler_->result_durable(worker, sent.lease, sent.job, sent.task,
                                   plan.passes.pass(sent.task.pass).count, 0.1,
                                   world_.events.now()));
  fold_on(sent.job, sent.task.frame, sent.task.tile);
}

std::uint32_t Coordinator::folded(JobId job, const TaskId& task) const {
  const auto film = films_.find(job);
  if (film == films_.end()) return 0;
  const auto tile = film->second.tiles.find({task.frame, task.tile});
  return tile == film->second.tiles.end() ? 0 : tile->second.passes;
}

void Coordinator::fold_on(JobId id, std::int32_t frame, std::uint32_t index) {
  Film& film = films_[id];
  if (!film.folding.emplace(frame, index).second) return;
  later(world_.random.between(0, world_.weather.fold_most), [this, id, frame, index] {
    Film& films = films_[id];
    films.folding.erase({frame, index});
    const Disk::Job& job = world_.disk.jobs.at(id);
    if (!job.ended.empty()) return;
    auto& tile =
        films.tiles.try_emplace({frame, index}, server::empty_film_tile(job.plan->grid.tile(index)))
            .first->second;
    const std::uint32_t before = tile.passes;
    if (world_.bug == Bug::fold_out_of_order) {
      const auto first = job.results.find({frame, index, before}),
                 second = job.results.find({frame, index, before + 1});
      if (first != job.results.end() && second != job.results.end()) {
        server::fold(tile, *second->second);
        server::fold(tile, *first->second);
      }
    }
    for (auto next = job.results.find({frame, index, tile.passes}); next != job.results.end();
         next = job.results.find({frame, index, tile.passes})) {
      server::fold(tile, *next->second);
      if (world_.bug == Bug::double_fold && tile.passes == 2) {
        server::fold(tile, *next->second);
        --tile.passes;
      }
    }
    if (tile.passes == before && world_.bug != Bug::ignore_fold_limit) return;
    const std::uint32_t told = tile.passes + (world_.bug == Bug::ignore_fold_limit ? 1 : 0);
    apply(scheduler_->tile_folded(id, frame, index, told, world_.events.now()));
  });
}

}  // namespace tessera::sim
