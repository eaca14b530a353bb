// A job whose time is limited ends at a whole pass of every tile.
#include "tests/unit/schedule/schedule_fixture.hpp"

namespace tessera::server {
namespace {

class TimeLimitTest : public ScheduleTest {
 protected:
  /// Ends 1, 4, 16, 64, 256, 512, …
  static JobSpec limited(double seconds, int tiles = 8) {
    JobSpec job = spec(tiles, 4096);
    job.time_limit_seconds = seconds;
    return job;
  }
  /// All workers render on, each sample of a tile in so many seconds, until the job is done.
  void render_all(double seconds_a_sample, double most = 1e6) {
    std::map<WorkerId, double> free_at;
    const Instant began = now_;
    while (finished_.empty() && seconds(now_ - began) < most) {
      WorkerId next = 0;
      double at = 1e18;
      for (const auto& [worker, grants] : held_) {
        if (grants.empty()) continue;
        const auto count = plans_[1]->passes.pass(grants[0].task.pass).count;
        const double begins = std::max(free_at[worker], seconds(now_ - began));
        const double ends =
            (free_at[worker] == 0 ? 0 : begins) + static_cast<double>(count) * seconds_a_sample;
        if (ends < at) at = ends, next = worker;
      }
      ASSERT_NE(next, 0U) << "somebody has something to do";
      for (const WorkerView& view : scheduler_.workers(now_))
        scheduler_.worker_heard(view.id, now_);
      while (seconds(now_ - began) + 2 < at) {
        pass(2);
        for (const WorkerView& view : scheduler_.workers(now_))
          scheduler_.worker_heard(view.id, now_);
      }
      pass(std::max(0.0, at - seconds(now_ - began)));
      free_at[next] = at;
      const GrantLease done = finish_one(next);
      passes_[done.task.tile] = std::max(passes_[done.task.tile], done.task.pass + 1);
    }
  }
  std::map<std::uint32_t, std::uint32_t> passes_;  // of each tile
};

TEST_F(TimeLimitTest, EveryTileEndsWithTheSamePassAndInTime) {
  // 8 tiles of 4,096 samples in 10 ms: 328 s for one worker.
  add(1, limited(60));
  ready(join("a"));
  const Instant began = now_;
  render_all(0.01);
  ASSERT_EQ(finished_, std::vector<JobId>{1});
  EXPECT_EQ(passes_.size(), 8U);
  for (const auto& [tile, passes] : passes_) EXPECT_EQ(passes, 6U) << "41 s; the next would be 61";
  EXPECT_LE(seconds(now_ - began), 60);
  EXPECT_EQ(shortened_[1], 512);
  const JobView view = *scheduler_.job(1, now_);
  EXPECT_EQ(view.state, "done");
  EXPECT_EQ(view.tasks, view.tasks_done);
  EXPECT_EQ(view.samples, view.samples_done);
}

TEST_F(TimeLimitTest, TheFirstPassIsAlwaysMade) {
  add(1, limited(0.5));
  ready(join("a"));
  render_all(1);
  for (const auto& [tile, passes] : passes_) EXPECT_EQ(passes, 1U);
  EXPECT_EQ(passes_.size(), 8U);
  EXPECT_EQ(shortened_[1], 1);
}

TEST_F(TimeLimitTest, WhatFitsIsNotShortened) {
  add(1, limited(3600));
  ready(join("a"));
  render_all(0.01);
  for (const auto& [tile, passes] : passes_) EXPECT_EQ(passes, plans_[1]->passes.count());
  EXPECT_TRUE(shortened_.empty());
}

TEST_F(TimeLimitTest, NoWorkerWaitsForAPassToEndBeforeTheNextBegins) {
  add(1, limited(3600, 3));
  const WorkerId a = join("a"), b = join("b");
  for (const WorkerId worker : {a, b}) ready(worker);
  for (int i = 0; i < 12; ++i) {
    pass(0.1);
    for (const WorkerId worker : {a, b}) {
      finish_one(worker);
      EXPECT_FALSE(held_[worker].empty());
    }
  }
}

TEST_F(TimeLimitTest, APassIsNotDecidedOnWhileTasksOfTheOneBeforeWaitForFolds) {
  JobSpec job = limited(60, 1);
  job.pass = 1;  // 4,096 passes of one tile
  add(1, job);
  const WorkerId worker = join("a");
  ready(worker);
  std::vector<GrantLease> in;
  while (!held_[worker].empty()) {
    pass(0.05);
    in.push_back(finish_one(worker, false));  // nothing is folded
  }
  EXPECT_EQ(in.size(), 3U);
  for (int i = 0; i < 100; ++i) {
    pass(0.5);
    scheduler_.worker_heard(worker, now_);
  }
  EXPECT_EQ(scheduler_.job(1, now_)->tasks, 4096) << "it was not cut";
}

TEST_F(TimeLimitTest, APassThatHasBegunIsFinishedForEveryTileThoughTimeRunsOut) {
  add(1, limited(60));
  const WorkerId b = join("b");
  ready(join("a"));
  ready(b);
  render_all(0.01, 26);  // in the pass that ends at 512
  leave(b, true);
  render_all(0.05);
  ASSERT_EQ(finished_.size(), 1U);
  std::set<std::uint32_t> ends;
  for (const auto& [tile, passes] : passes_) ends.insert(passes);
  EXPECT_EQ(ends.size(), 1U);
}

TEST_F(TimeLimitTest, AfterAStartItCountsFromTheFirstLeaseAndWhatWasBegunIsFinished) {
  const auto plan = std::make_shared<const JobPlan>(limited(60));
  plans_[1] = plan;
  take(scheduler_.add_job(1, plan, now_));
  scheduler_.restore_started(1, now_ - std::chrono::seconds(59));
  for (std::uint32_t tile = 0; tile < 8; ++tile)
    for (std::uint32_t pass = 0; pass < (tile == 3 ? 6U : 5U); ++pass)
      scheduler_.restore_closed(1, {1, tile, pass});
  for (std::uint32_t tile = 0; tile < 8; ++tile)
    take(scheduler_.tile_folded(1, 1, tile, tile == 3 ? 6 : 5, now_));
  ready(join("a"));
  passes_[3] = 6;
  render_all(0.01);
  for (std::uint32_t tile = 0; tile < 8; ++tile) EXPECT_EQ(passes_[tile], 6U);
  EXPECT_EQ(shortened_[1], 512);
}

/// Four tiles, of which three have pass 1 still to come; "a" holds a lease of pass 2 from
/// before.
class TimeLimitRestartTest : public TimeLimitTest {
 protected:
  TimeLimitRestartTest() : again_(second_epoch()) {
    add(1, limited(3600, 4));
    const WorkerId a = join("a"), b = join("b");
    ready(a);
    ready(b);
    while (held_[a].at(0).task.pass < 2) {
      pass(0.1);
      const GrantLease done = finish_one(held_[b].at(0).task.pass < 1 ? b : a);
      passes_[done.task.tile] = done.task.pass + 1;
    }
    passes_[finish_one(b).task.tile] = 2;  // pass 1 has begun
    old_ = held_[a].at(0);
  }
  /// The farm has been at the job for so long, and comes back with "a" alone.
  void restart(double seconds) {
    held_.clear();
    take(again_.add_job(1, plans_[1], now_));
    take(again_.pause_job(1, now_));
    again_.restore_started(
        1, now_ - std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds)));
    for (const auto& [tile, passes] : passes_)
      for (std::uint32_t pass = 0; pass < passes; ++pass) again_.restore_closed(1, {1, tile, pass});
    for (const auto& [tile, passes] : passes_) take(again_.tile_folded(1, 1, tile, passes, now_));
    take(again_.resume_job(1, now_));
    auto joined = again_.worker_joined({"a", "a", 1, digest_of("build")}, now_);
    worker_ = joined.worker;
    take(joined.actions);
    take(again_.worker_ready(worker_, 1, now_));
  }
  Verdict arrives(const GrantLease& grant) {
    return again_.result_arrived(worker_, grant.lease, 1, plans_[1]->digest, grant.task, now_);
  }
  void kept(const GrantLease& grant) {
    take(again_.result_durable(worker_, grant.lease, 1, grant.task, 256, 0.1, now_));
    take(again_.tile_folded(1, 1, grant.task.tile, grant.task.pass + 1, now_));
  }
  void render_what_is_granted() {
    while (!held_[worker_].empty()) {
      const GrantLease next = held_[worker_][0];
      held_[worker_].erase(held_[worker_].begin());
      EXPECT_EQ(arrives(next), Verdict::take);
      kept(next);
    }
  }

  Scheduler again_;
  WorkerId worker_ = 0;
  GrantLease old_{};

 private:
  [[nodiscard]] SchedulerSettings second_epoch() const {
    SchedulerSettings settings = settings_;
    settings.epoch = 2;
    return settings;
  }
};

TEST_F(TimeLimitRestartTest, AnOldResultOfAPassThatIsNotRenderedAnyMoreIsStale) {
  ASSERT_EQ(old_.task.pass, 2U);
  restart(3600);
  ASSERT_FALSE(held_[worker_].empty());
  const GrantLease first = held_[worker_][0];
  held_[worker_].erase(held_[worker_].begin());
  EXPECT_EQ(arrives(first), Verdict::take);
  kept(first);
  ASSERT_FALSE(held_[worker_].empty()) << "the last of pass 1 is handed out, and not done";
  EXPECT_EQ(arrives(old_), Verdict::stale);
  render_what_is_granted();
  EXPECT_EQ(shortened_[1], 4);
  EXPECT_EQ(finished_, std::vector<JobId>{1});
}

TEST_F(TimeLimitRestartTest, AnOldResultOfALaterPassLetsThatPassBeginForEveryTile) {
  restart(3600 - 1e-3);
  EXPECT_EQ(arrives(old_), Verdict::take);
  kept(old_);
  render_what_is_granted();
  EXPECT_EQ(shortened_[1], 16);
  EXPECT_EQ(finished_, std::vector<JobId>{1});
}

TEST_F(TimeLimitRestartTest, ThePaceSoFarTellsWhetherAPassIsInTimeWhereNobodyWasMeasured) {
  restart(3600 - 1e-3);
  render_what_is_granted();
  EXPECT_EQ(shortened_[1], 4) << "the next pass takes three times what those before it took";
}

TEST_F(TimeLimitRestartTest, AResultOfTheSamplesThatItHadBeforeItsTimeWasUpIsStaleAndNobodysFault) {
  JobSpec shorter = plans_[1]->spec;
  shorter.render.samples = 16;
  const Digest before = plans_[1]->digest;
  plans_[1] = std::make_shared<const JobPlan>(shorter);
  restart(3600);
  for (int i = 0; i < 2 * settings_.offences; ++i)
    EXPECT_EQ(again_.result_arrived(worker_, old_.lease, 1, before, old_.task, now_),
              Verdict::stale);
  LeaseId invented = old_.lease;
  ++invented.number;
  EXPECT_EQ(again_.result_arrived(worker_, invented, 1, before, old_.task, now_),
            Verdict::rejected);
  EXPECT_EQ(again_.workers(now_).at(0).state.find("quarantined"), std::string::npos);
}

TEST_F(TimeLimitTest, TheTimeToFinishIsWithinTheLimit) {
  add(1, limited(60));
  ready(join("a"));
  render_all(0.01, 10);
  const JobView view = *scheduler_.job(1, now_);
  ASSERT_TRUE(view.eta_seconds);
  EXPECT_LE(*view.eta_seconds, 50.1);
  EXPECT_LE(*view.eta_high_seconds, 50.1);
}

}  // namespace
}  // namespace tessera::server
