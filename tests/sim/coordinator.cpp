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

void Coordinator::pause(JobId job, double duration) {
  if (!up() || !world_.disk.jobs.at(job).ended.empty()) return;
  paused_.insert(job);
  apply(scheduler_->pause_job(job, world_.events.now()));
  later(duration, [this, job] {
    paused_.erase(job);
    apply(scheduler_->resume_job(job, world_.events.now()));
  });
}

void Coordinator::set_focus(JobId job, const std::optional<Rect>& focus) {
  if (!up() || !world_.disk.jobs.contains(job) || !world_.disk.jobs.at(job).ended.empty()) return;
  focus_[job] = focus;
  apply(scheduler_->set_focus(job, focus, world_.events.now()));
}

bool Coordinator::all_ended() const {
  return up() && world_.unanswered == 0 &&
         std::all_of(world_.disk.jobs.begin(), world_.disk.jobs.end(),
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
  auto verdict = scheduler_->result_arrived(link->known_as, sent.lease, sent.job, sent.plan,
                                            sent.task, world_.events.now());
  world_.tell("job {} {} from worker {}: {}", sent.job, text_of(sent.task), link->known_as,
              verdict == server::Verdict::take ? "taken" : "stale");
  require(verdict != server::Verdict::rejected,
          "a lease that was granted to this identity is known again");
  release(sent.lease);
  if (verdict == server::Verdict::take) {
    doubted_.erase({sent.job, sent.task});
    // One that was granted in an earlier epoch begins its pass.
    std::uint32_t& begun = passes_begun_[sent.job];
    begun = std::max(begun, sent.task.pass + 1);
    this->begun(sent.job, sent.task);
  }
  world_.note(static_cast<std::uint64_t>(verdict));
  if (world_.bug == Bug::keep_without_asking) verdict = server::Verdict::take;
  if (verdict == server::Verdict::stale) {
    world_.carry(link, false, [this, link, lease = sent.lease] { link->worker->answered(lease); });
  } else {
    require(world_.bug != Bug::none || !job.results.contains(sent.task),
            "a closed task's result is stale");
    arrived_.emplace(sent.job, sent.task);
    if (sent.corrupt) doubted_.emplace(sent.job, sent.task);
    const Arrived arrived{link, link->known_as, sent, nullptr, nullptr, {}};
    later(world_.random.between(0, 0.01), [this, arrived] { decoded(arrived); });
  }
  arm();
}

void Coordinator::decoded(Arrived arrived) {
  const auto& [link, worker, sent, bytes, tile, place] = arrived;
  if (sent.corrupt) {
    arrived_.erase({sent.job, sent.task});
    excused_[worker] = world_.events.now() + from_seconds(80);
    world_.carry(link, false, [to = link, lease = sent.lease] { to->worker->answered(lease); });
    apply(scheduler_->result_invalid(worker, sent.lease, sent.job, sent.task, "no tile",
                                     world_.events.now()));
    return;
  }
  const JobPlan& plan = *world_.disk.jobs.at(sent.job).plan;
  arrived.bytes = bytes_of(render(plan, sent.task));
  arrived.decoded =
      std::make_shared<server::DecodedTile>(sim::decode(arrived.bytes, plan, sent.task));
  journal_.push_back(std::move(arrived));
  commit();
}

}  // namespace tessera::sim
