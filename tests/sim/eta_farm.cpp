#include "tests/sim/eta_farm.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "server/schedule/scheduler.hpp"
#include "tests/sim/events.hpp"
#include "tests/sim/ledger.hpp"

namespace tessera::sim {
namespace {

using server::GrantLease;
constexpr JobId looked_at = 1;

double normal(Random& random) {
  const double radius = std::sqrt(-2 * std::log(1 - random.unit()));
  return radius * std::cos(2 * std::numbers::pi * random.unit());
}

/// A worker process: renders in order, one task at a time.
struct Process {
  double speed = 1;
  std::deque<GrantLease> queue;
  std::optional<GrantLease> running;
  Instant since{};
  double takes = 0;  // seconds, what runs
  std::uint64_t begun = 0;
  std::set<JobId> prepared;
};

class Farm {
 public:
  explicit Farm(const EtaModel& model) : model_(model), random_(model.seed), scheduler_({}) {}

  std::vector<EtaLook> run() {
    set_up();
    while (!ended_) {
      require(events_.step(), "something is left to happen");
      arm();
    }
    for (EtaLook& look : looks_) look.truth = *ended_ - look.truth;
    return looks_;
  }

 private:
  /// One that is rendered, of so much of the work of the model's.
  struct Job {
    std::shared_ptr<const JobPlan> plan;
    std::vector<double> costs;  // work of one sample, by tile; the same in each frame
    std::map<std::pair<std::int32_t, std::uint32_t>, std::uint32_t> folded, early;
  };

  void add_job(JobId id, double size, int frames, int priority) {
    JobSpec spec;
    spec.name = "job";
    spec.bundle = digest_of("bundle " + std::to_string(id));
    spec.render.width = model_.columns;
    spec.render.height = model_.rows;
    spec.render.samples = model_.samples;
    spec.tile = 1;
    spec.frames = {1, frames, 1};
    spec.priority = priority;
    Job& job = jobs_[id];
    job.plan = std::make_shared<const JobPlan>(spec);
    job.costs.resize(job.plan->grid.count());
    double total = 0;
    for (double& cost : job.costs) total += cost = std::exp(model_.roughness * normal(random_));
    const double power = model_.workers * (1 + model_.spread) / 2;
    for (double& cost : job.costs)
      cost *=
          size * model_.job_seconds * power / total / static_cast<double>(model_.samples) / frames;
    apply(scheduler_.add_job(id, job.plan, events_.now()));
  }

  void set_up() {
    add_job(looked_at, 1, model_.frames, 0);
    JobId next = looked_at;
    for (const EtaModel::Rival& rival : model_.rivals)
      events_.after(rival.after, [this, rival, id = ++next] {
        if (!ended_) add_job(id, rival.size, 1, rival.priority);
      });
    for (int i = 0; i < model_.workers; ++i) {
      const bool later = random_.chance(model_.ramp);
      events_.after(later ? random_.between(0, model_.job_seconds / 2) : random_.between(0, 2),
                    [this] { join(); });
    }
    if (model_.turnover > 0) {
      leave_later();
      join_later();
    }
    look();
  }

  void join() {
    const std::string name = "worker " + std::to_string(++joined_);
    const auto worker =
        scheduler_.worker_joined({name, name, 1, digest_of("build")}, events_.now());
    Process& process = processes_[worker.worker];
    process.speed = random_.between(1, model_.spread);
    apply(worker.actions);
    beat(worker.worker);
  }
  double between_changes() {
    const double mean = model_.job_seconds / (model_.turnover * model_.workers);
    return -std::log(1 - random_.unit()) * mean;
  }
  void leave_later() {
    events_.after(between_changes(), [this] {
      if (processes_.size() > 1) {
        auto gone = processes_.begin();
        std::advance(gone, random_.whole(0, static_cast<std::int64_t>(processes_.size()) - 1));
        const server::WorkerId id = gone->first;
        processes_.erase(gone);
        apply(scheduler_.worker_left(id, true, events_.now()));
      }
      leave_later();
    });
  }
  void join_later() {
    events_.after(between_changes(), [this] {
      join();
      join_later();
    });
  }

  void apply(const server::Actions& actions) {
    for (const server::Action& action : actions) {
      if (const auto* grant = std::get_if<GrantLease>(&action)) {
        processes_.at(grant->worker).queue.push_back(*grant);
        go_on(grant->worker);
      } else if (const auto* revoke = std::get_if<server::RevokeLeases>(&action)) {
        for (const LeaseId& lease : revoke->leases) revoked(revoke->worker, lease);
      } else if (const auto* finished = std::get_if<server::JobFinished>(&action)) {
        if (finished->job == looked_at) ended_ = events_.seconds_now();
      } else {
        require(std::holds_alternative<server::FrameFinished>(action), "a calm farm stays calm");
      }
    }
  }
  /// Later, so that the scheduler is not called from within its own actions.
  void go_on(server::WorkerId id) {
    events_.after(0.001, [this, id] {
      const auto found = processes_.find(id);
      if (found == processes_.end() || ended_) return;
      Process& process = found->second;
      if (process.running || process.queue.empty()) return;
      if (const JobId job = process.queue.front().job; process.prepared.insert(job).second) {
        apply(scheduler_.worker_ready(id, job, events_.now()));
        if (process.running || process.queue.empty()) return;
      }
      process.running = process.queue.front();
      process.queue.pop_front();
      process.since = events_.now();
      const TaskId& task = process.running->task;
      const Job& job = jobs_.at(process.running->job);
      const double work =
          job.costs[task.tile] * static_cast<double>(job.plan->passes.pass(task.pass).count);
      process.takes = work / process.speed + 0.001;
      const std::uint64_t begun = ++process.begun;
      events_.after(process.takes, [this, id, begun] { rendered(id, begun); });
    });
  }
  void revoked(server::WorkerId id, const LeaseId& lease) {
    const auto found = processes_.find(id);
    if (found == processes_.end()) return;
    Process& process = found->second;
    std::erase_if(process.queue, [&](const GrantLease& grant) { return grant.lease == lease; });
    if (!process.running || process.running->lease != lease) return;
    process.running.reset();
    ++process.begun;
    go_on(id);
  }
  void rendered(server::WorkerId id, std::uint64_t begun) {
    const auto found = processes_.find(id);
    if (found == processes_.end() || found->second.begun != begun || ended_) return;
    const GrantLease grant = *std::exchange(found->second.running, std::nullopt);
    const TaskId& task = grant.task;
    Job& job = jobs_.at(grant.job);
    go_on(id);
    const auto verdict = scheduler_.result_arrived(id, grant.lease, grant.job, job.plan->digest,
                                                   task, events_.now());
    require(verdict != server::Verdict::rejected, "an honest result is taken");
    if (verdict != server::Verdict::take) return;
    apply(scheduler_.result_durable(id, grant.lease, grant.job, task,
                                    job.plan->passes.pass(task.pass).count, 0, events_.now()));
    std::uint32_t& passes = job.folded[{task.frame, task.tile}];
    std::uint32_t& early = job.early[{task.frame, task.tile}];
    early |= 1U << (task.pass - passes);
    for (; (early & 1) != 0; early >>= 1) ++passes;
    apply(scheduler_.tile_folded(grant.job, task.frame, task.tile, passes, events_.now()));
  }
  void beat(server::WorkerId id) {
    const auto found = processes_.find(id);
    if (found == processes_.end() || ended_) return;
    const Process& process = found->second;
    std::vector<std::pair<LeaseId, double>> running;
    if (process.running)
      running.emplace_back(process.running->lease,
                           std::min(1.0, seconds(events_.now() - process.since) / process.takes));
    apply(scheduler_.worker_progress(id, running, events_.now()));
    events_.after(1, [this, id] { beat(id); });
  }
  void look() {
    if (ended_) return;
    const auto view = scheduler_.job(looked_at, events_.now());
    const double progress =
        static_cast<double>(view->samples_done) / static_cast<double>(view->samples);
    if (progress >= 0.1 && view->eta_seconds) {
      looks_.push_back({progress, *view->eta_seconds, *view->eta_low_seconds,
                        *view->eta_high_seconds, events_.seconds_now()});
    }
    events_.after(model_.job_seconds / 200, [this] { look(); });
  }
  void arm() {
    const auto next = scheduler_.next_deadline();
    if (!next || (armed_ && *armed_ <= *next && *armed_ > events_.now())) return;
    armed_ = std::max(*next, events_.now());
    events_.at(*armed_, [this, instant = *armed_] {
      if (armed_ != instant || ended_) return;
      armed_.reset();
      apply(scheduler_.tick(events_.now()));
    });
  }

  EtaModel model_;
  Random random_;
  Events events_;
  server::Scheduler scheduler_;
  std::map<JobId, Job> jobs_;
  std::map<server::WorkerId, Process> processes_;
  std::vector<EtaLook> looks_;  // `truth` holds the instant until the end is known
  std::optional<Instant> armed_;
  std::optional<double> ended_;
  int joined_ = 0;
};

}  // namespace

EtaModel draw_eta_model(std::uint64_t seed) {
  Random random(seed * 2654435761U + 17);
  EtaModel model;
  model.seed = seed;
  model.workers = static_cast<int>(std::exp(random.between(std::log(3), std::log(100))));
  model.spread = random.chance(0.3) ? 1 : 10;
  const double tiles = model.workers * std::exp(random.between(std::log(4), std::log(60)));
  model.columns = std::max(4, static_cast<int>(std::sqrt(tiles * 16 / 9)));
  model.rows = std::max(3, static_cast<int>(std::sqrt(tiles * 9 / 16)));
  model.samples = std::int64_t{64} << random.whole(0, 5);
  model.roughness = random.between(0, 1);
  model.job_seconds = std::exp(random.between(std::log(60), std::log(3600)));
  if (random.chance(0.3)) model.ramp = random.between(0.1, 0.8);
  if (random.chance(0.5)) model.turnover = random.between(0.2, 3);
  return model;
}

EtaModel draw_shared_eta_model(std::uint64_t seed) {
  EtaModel model = draw_eta_model(seed);
  Random random(seed * 2246822519U + 29);
  if (random.chance(0.5)) model.frames = static_cast<int>(random.whole(2, 12));
  const auto rivals = random.whole(model.frames > 1 ? 0 : 1, 4);
  for (std::int64_t i = 0; i < rivals; ++i) {
    EtaModel::Rival rival;
    rival.size = std::exp(random.between(std::log(0.1), std::log(4)));
    if (random.chance(0.4)) rival.after = random.between(0, model.job_seconds);
    if (random.chance(0.3)) rival.priority = static_cast<int>(random.whole(-5, 5));
    model.rivals.push_back(rival);
  }
  return model;
}

std::vector<EtaLook> eta_looks(const EtaModel& model) { return Farm(model).run(); }

}  // namespace tessera::sim
