// The scheduler on its own, under virtual time: what a decision costs with ten workers and with ten
// thousand, and how long a frame's tail is beside what it could be.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <deque>
#include <memory>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "common/base/thread_clock.hpp"
#include "server/schedule/scheduler.hpp"
#include "tests/bench/print.hpp"
#include "tests/sim/model.hpp"

namespace tessera {
namespace {

using server::Actions;
using server::GrantLease;

constexpr JobId job = 1;
constexpr double task_seconds = 0.2;

/// Workers of the same speed that finish a task one after the other, each its oldest.
class Steady {
 public:
  Steady(int workers, int side) : held_(static_cast<std::size_t>(workers)) {
    JobSpec spec;
    spec.name = "job";
    spec.bundle = digest_of("bundle");
    spec.render.width = side;
    spec.render.height = side;
    spec.render.samples = 20;  // three passes
    spec.tile = 1;
    plan_ = std::make_shared<const JobPlan>(spec);
    apply(scheduler_.add_job(job, plan_, now_));
    for (int i = 0; i < workers; ++i) {
      const std::string name = "worker " + std::to_string(i);
      const auto joined = scheduler_.worker_joined({name, name, 1, digest_of("build")}, now_);
      ids_.push_back(joined.worker);
      apply(joined.actions);
      apply(scheduler_.worker_ready(joined.worker, job, now_));
    }
  }

  /// Until so many leases were granted; the CPU seconds that the scheduler took for it.
  double run(std::int64_t grants) {
    const std::int64_t end = grants_ + grants;
    const double started = thread_cpu_seconds();
    for (std::size_t turn = 0; grants_ < end; turn = (turn + 1) % held_.size()) {
      pass(task_seconds / static_cast<double>(held_.size()));
      if (held_[turn].empty()) throw std::runtime_error("a worker has no work");
      finish(turn);
    }
    return thread_cpu_seconds() - started;
  }

 private:
  void pass(double time) {
    now_ += std::chrono::duration_cast<Duration>(std::chrono::duration<double>(time));
    const auto deadline = scheduler_.next_deadline();
    if (deadline && *deadline <= now_) apply(scheduler_.tick(now_));
  }
  void finish(std::size_t turn) {
    const GrantLease grant = held_[turn].front();
    held_[turn].pop_front();
    const std::int64_t samples = plan_->passes.pass(grant.task.pass).count;
    const auto verdict =
        scheduler_.result_arrived(grant.worker, grant.lease, job, plan_->digest, grant.task, now_);
    if (verdict != server::Verdict::take) throw std::runtime_error("a result is not taken");
    apply(scheduler_.result_durable(grant.worker, grant.lease, job, grant.task, samples,
                                    task_seconds, now_));
    apply(
        scheduler_.tile_folded(job, grant.task.frame, grant.task.tile, grant.task.pass + 1, now_));
  }
  void apply(const Actions& actions) {
    for (const auto& action : actions) {
      const auto* grant = std::get_if<GrantLease>(&action);
      if (grant == nullptr) continue;
      ++grants_;
      held_[static_cast<std::size_t>(grant->worker - ids_front())].push_back(*grant);
    }
  }
  /// Ids are given in the order of joining.
  [[nodiscard]] server::WorkerId ids_front() const { return ids_.empty() ? 1 : ids_.front(); }

  server::Scheduler scheduler_{server::SchedulerSettings{}};
  Instant now_{std::chrono::seconds(1000)};
  std::shared_ptr<const JobPlan> plan_;
  std::vector<server::WorkerId> ids_;
  std::vector<std::deque<GrantLease>> held_;
  std::int64_t grants_ = 0;
};

void decisions(std::int64_t grants) {
  double of_ten = 0;
  for (const int workers : {10, 1000, 10000}) {
    const std::int64_t all = grants + 20LL * workers;
    Steady farm(workers, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(all)))));
    farm.run(4LL * workers);  // until speeds are known and windows full
    const double cost = farm.run(grants) / static_cast<double>(grants);
    if (workers == 10) of_ten = cost;
    const std::string who = std::to_string(workers) + " workers";
    farm_test::print("decisions of the scheduler, " + who, 1 / cost, "1/s", "");
    farm_test::print("  cost of one over that with 10 workers", cost / of_ten, "ratio", "");
  }
}

void tail(int workers, int copies_most) {
  sim::Model model;
  model.workers = workers;
  model.copies_most = copies_most;
  const sim::Measured measured = sim::measure(model);
  farm_test::print("tail of a 4K frame, " + std::to_string(workers) + " workers of speeds 1-10, " +
                       (copies_most > 1 ? "duplicates" : "none"),
                   measured.tail, "s", "");
  farm_test::print("  its ideal: what was left, at the speed of all", measured.tail_ideal, "s", "");
  farm_test::print("  tail over an average full task's time", measured.tail / model.task_seconds,
                   "ratio", "");
}

}  // namespace
}  // namespace tessera

/// bench_schedule [--quick]
int main(int count, char** arguments) {
  const bool quick = count > 1 && std::strcmp(arguments[1], "--quick") == 0;
  tessera::decisions(quick ? 20'000 : 200'000);
  for (const int workers : {10, 100}) {
    tessera::tail(workers, 1);
    tessera::tail(workers, 3);
  }
  return 0;
}
