#include "tests/sim/model.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <numbers>
#include <optional>
#include <queue>
#include <string>
#include <unordered_set>

#include "server/schedule/scheduler.hpp"
#include "tests/sim/events.hpp"
#include "tests/sim/ledger.hpp"

namespace tessera::sim {
namespace {

using server::GrantLease;

constexpr JobId job = 1;
constexpr double heartbeat = 1, sync_seconds = 0.01;

enum class Kind { assign, rendered, result, durable, revoke, beat, slow_down, tick };

struct Event {
  Instant at;
  std::uint64_t sequence = 0;
  Kind kind = Kind::tick;
  std::size_t worker = 0;
  GrantLease grant;         // assign, rendered, result, durable, revoke
  std::uint64_t begun = 0;  // rendered
  bool operator>(const Event& other) const {
    return at != other.at ? at > other.at : sequence > other.sequence;
  }
};

/// A worker process: renders in order, one at a time.
struct Process {
  double speed = 1;
  server::WorkerId id = 0;
  std::deque<GrantLease> queue;
  std::optional<GrantLease> running;
  double left = 0;  // work of what runs, at `since`
  double whole = 0;
  Instant since{}, started{};
  std::uint64_t begun = 0;
  bool prepared = false;
};

class Farm {
 public:
  explicit Farm(const Model& model)
      : model_(model), random_(model.seed), scheduler_(settings(model)) {}

  Measured run() {
    set_up();
    while (!done_) {
      require(!queue_.empty(), "something is left to happen");
      const Event event = queue_.top();
      queue_.pop();
      now_ = event.at;
      happen(event);
      arm();
    }
    return finish();
  }

 private:
  static server::SchedulerSettings settings(const Model& model) {
    server::SchedulerSettings settings;
    settings.copies_most = model.copies_most;
    return settings;
  }
  void set_up() {
    JobSpec spec;
    spec.name = "job";
    spec.bundle = digest_of("bundle");
    spec.render.width = static_cast<int>(std::ceil(std::sqrt(model_.tiles)));
    spec.render.height = spec.render.width;
    spec.render.samples = model_.samples;
    spec.tile = 1;
    plan_ = std::make_shared<const JobPlan>(spec);
    costs_.resize(plan_->grid.count());
    for (double& cost : costs_) cost = std::exp(model_.roughness * normal());
    double total = 0, power = 0;
    for (const double cost : costs_) total += cost;
    // Work is told in seconds at speed 1; an average tile takes task_seconds at average speed.
    const double scale = static_cast<double>(costs_.size()) / total * model_.task_seconds *
                         (1 + model_.spread) / 2 / 256;
    for (double& cost : costs_) cost *= scale;
    apply(scheduler_.add_job(job, plan_, now_));
    processes_.resize(static_cast<std::size_t>(model_.workers));
    for (std::size_t i = 0; i < processes_.size(); ++i) {
      const std::string name = "worker " + std::to_string(i);
      const auto joined = scheduler_.worker_joined({name, name, 1, digest_of("build")}, now_);
      processes_[i].speed = random_.between(1, model_.spread);
      processes_[i].id = joined.worker;
      power += processes_[i].speed;
      places_.resize(joined.worker + 1);
      places_[joined.worker] = i;
      apply(joined.actions);
      push(heartbeat * random_.unit(), {.kind = Kind::beat, .worker = i});
      if (random_.chance(model_.slowdown))
        push(200 * random_.unit(), {.kind = Kind::slow_down, .worker = i});
    }
    work_ = total * scale * static_cast<double>(model_.samples);
    measured_.ideal = work_ / power;
    power_ = power;
    began_ = now_;
  }
  double normal() {
    const double radius = std::sqrt(-2 * std::log(1 - random_.unit()));
    return radius * std::cos(2 * std::numbers::pi * random_.unit());
  }
  [[nodiscard]] double work_of(const TaskId& task) const {
    return costs_[task.tile] * static_cast<double>(plan_->passes.pass(task.pass).count);
  }
  void push(double delay, Event event) {
    event.at = now_ + from_seconds(delay);
    event.sequence = ++sequence_;
    queue_.push(event);
  }
  void arm() {
    const auto next = scheduler_.next_deadline();
    if (!next || (armed_ && *armed_ <= *next && *armed_ > now_)) return;
    armed_ = std::max(*next, now_);
    push(seconds(*armed_ - now_), {.kind = Kind::tick});
  }

  void apply(const server::Actions& actions) {
    for (const server::Action& action : actions) {
      if (const auto* grant = std::get_if<GrantLease>(&action)) {
        ++measured_.grants;
        if (granted_.insert(grant->task).second) {
          last_first_ = now_;
          closed_at_last_first_ = closed_work_;
        }
        push(model_.latency,
             {.kind = Kind::assign, .worker = places_[grant->worker], .grant = *grant});
      } else if (const auto* revoke = std::get_if<server::RevokeLeases>(&action)) {
        for (const LeaseId& lease : revoke->leases) {
          push(model_.latency, {.kind = Kind::revoke,
                                .worker = places_[revoke->worker],
                                .grant = {revoke->worker, lease, job, {}}});
        }
      } else if (std::holds_alternative<server::JobFinished>(action)) {
        done_ = true;
      } else {
        require(std::holds_alternative<server::FrameFinished>(action), "a calm farm stays calm");
      }
    }
  }

  void happen(const Event& event) {
    Process& process = processes_[event.worker];
    switch (event.kind) {
      case Kind::assign:
        process.queue.push_back(event.grant);
        return go_on(event.worker);
      case Kind::rendered:
        return rendered(event);
      case Kind::result:
        return result(event);
      case Kind::durable:
        return durable(event.worker, event.grant);
      case Kind::revoke:
        return revoked(event.worker, event.grant.lease);
      case Kind::beat:
        return beat(event.worker);
      case Kind::slow_down:
        return slow_down(event.worker);
      case Kind::tick:
        if (armed_ != event.at) return;
        armed_.reset();
        return apply(scheduler_.tick(now_));
    }
  }
  void go_on(std::size_t place) {
    Process& process = processes_[place];
    if (!process.prepared) {
      process.prepared = true;
      apply(scheduler_.worker_ready(process.id, job, now_));
    }
    if (process.running || process.queue.empty()) return;
    process.running = process.queue.front();
    process.queue.pop_front();
    process.whole = process.left = work_of(process.running->task) + model_.overhead * process.speed;
    process.since = process.started = now_;
    push(process.left / process.speed, {.kind = Kind::rendered,
                                        .worker = place,
                                        .grant = *process.running,
                                        .begun = ++process.begun});
  }
  void rendered(const Event& event) {
    Process& process = processes_[event.worker];
    if (!process.running || process.begun != event.begun) return;
    process.running.reset();
    Event sent = event;
    sent.kind = Kind::result;
    push(model_.latency, sent);
    go_on(event.worker);
  }
  void result(const Event& event) {
    const GrantLease& grant = event.grant;
    const auto verdict = scheduler_.result_arrived(processes_[event.worker].id, grant.lease, job,
                                                   plan_->digest, grant.task, now_);
    require(verdict != server::Verdict::rejected, "an honest result is taken");
    if (verdict != server::Verdict::take) {
      wasted_ += work_of(grant.task) / processes_[event.worker].speed;
      return;
    }
    Event kept = event;
    kept.kind = Kind::durable;
    push(sync_seconds, kept);
  }
  void durable(std::size_t place, const GrantLease& grant) {
    closed_work_ += work_of(grant.task);
    apply(scheduler_.result_durable(processes_[place].id, grant.lease, job, grant.task,
                                    plan_->passes.pass(grant.task.pass).count, 0, now_));
    apply(scheduler_.tile_folded(job, grant.task.frame, grant.task.tile, passes_folded(grant.task),
                                 now_));
  }
  /// Passes that are there without a gap.
  std::uint32_t passes_folded(const TaskId& task) {
    if (folded_.empty()) folded_.resize(plan_->grid.count()), early_.resize(plan_->grid.count());
    std::uint32_t& passes = folded_[task.tile];
    early_[task.tile] |= 1U << (task.pass - passes);
    while ((early_[task.tile] & 1) != 0) early_[task.tile] >>= 1, ++passes;
    return passes;
  }
  void revoked(std::size_t place, const LeaseId& lease) {
    Process& process = processes_[place];
    std::erase_if(process.queue, [&](const GrantLease& grant) { return grant.lease == lease; });
    if (!process.running || process.running->lease != lease) return;
    wasted_ += seconds(now_ - process.started);
    process.running.reset();
    ++process.begun;
    go_on(place);
  }
  void beat(std::size_t place) {
    Process& process = processes_[place];
    std::vector<std::pair<LeaseId, double>> running;
    if (process.running) {
      const double left = process.left - seconds(now_ - process.since) * process.speed;
      running.emplace_back(process.running->lease, 1 - left / process.whole);
    }
    apply(scheduler_.worker_progress(process.id, running, now_));
    push(heartbeat, {.kind = Kind::beat, .worker = place});
  }
  void slow_down(std::size_t place) {
    Process& process = processes_[place];
    if (process.running) {
      process.left -= seconds(now_ - process.since) * process.speed;
      process.since = now_;
      push(process.left / (process.speed / 10), {.kind = Kind::rendered,
                                                 .worker = place,
                                                 .grant = *process.running,
                                                 .begun = ++process.begun});
    }
    process.speed /= 10;
  }
  Measured finish() {
    measured_.seconds = seconds(now_ - began_);
    measured_.tail = seconds(now_ - last_first_);
    measured_.tail_ideal = (work_ - closed_at_last_first_) / power_;
    measured_.wasted = wasted_ / (measured_.seconds * model_.workers);
    measured_.tasks = plan_->tasks();
    return measured_;
  }

  Model model_;
  Random random_;
  server::Scheduler scheduler_;
  std::shared_ptr<const JobPlan> plan_;
  std::vector<double> costs_;  // work of one sample, by tile
  std::vector<Process> processes_;
  std::vector<std::size_t> places_;  // by worker id
  std::unordered_set<TaskId> granted_;
  std::vector<std::uint32_t> folded_, early_;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> queue_;
  Instant now_{std::chrono::hours(1)}, began_{}, last_first_{};
  std::optional<Instant> armed_;
  std::uint64_t sequence_ = 0;
  double work_ = 0, power_ = 0, closed_work_ = 0, closed_at_last_first_ = 0, wasted_ = 0;
  bool done_ = false;
  Measured measured_;
};

}  // namespace

Measured measure(const Model& model) { return Farm(model).run(); }

}  // namespace tessera::sim
