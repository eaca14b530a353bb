// What goes out, to whom, and in which order.
#include <cmath>

#include "tests/unit/schedule/schedule_fixture.hpp"

namespace tessera::server {
namespace {

TEST_F(ScheduleTest, AWorkerThatWasNotMeasuredHoldsTwoTasks) {
  add(1, spec(10, 1));
  const WorkerId worker = join("a");
  EXPECT_EQ(held_[worker].size(), 2);
  EXPECT_EQ(scheduler_.job(1, now_)->state, "rendering");
  EXPECT_EQ(scheduler_.workers(now_).at(0).state, "preparing");
}

TEST_F(ScheduleTest, TheFirstPassGoesOverTheWholeFrameFirst) {
  add(1, spec(5, 64));
  const WorkerId worker = join("a");
  ready(worker);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> order;
  while (!held_[worker].empty()) {
    pass(0.6);
    const TaskId task = finish_one(worker).task;
    order.emplace_back(task.pass, task.tile);
  }
  ASSERT_EQ(order.size(), 5 * plans_[1]->passes.count());
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
  EXPECT_EQ(finished_, std::vector<JobId>{1});
  EXPECT_EQ(frames_, std::vector<std::int32_t>{1});
  EXPECT_EQ(scheduler_.job(1, now_)->state, "done");
}

TEST_F(ScheduleTest, NoPassGoesOutThreeBeyondItsTilesFold) {
  add(1, spec(1, 256 * 10));
  const WorkerId worker = join("a");
  ready(worker);
  std::vector<GrantLease> in;
  while (!held_[worker].empty()) {
    pass(0.001);
    in.push_back(finish_one(worker, false));
  }
  ASSERT_EQ(in.size(), 3);
  EXPECT_EQ(in.back().task.pass, 2);
  fold(1, in[0].task);
  ASSERT_EQ(held_[worker].size(), 1);
  EXPECT_EQ(held_[worker][0].task.pass, 3);
}

TEST_F(ScheduleTest, TheWindowFollowsTheMeasuredSpeed) {
  add(1, spec(2000, 1));
  const WorkerId worker = join("a");
  ready(worker);
  for (int i = 0; i < 200; ++i) {
    pass(0.02);  // 50 tasks a second
    finish_one(worker);
  }
  EXPECT_GE(held_[worker].size(), 45);
  EXPECT_LE(held_[worker].size(), 56);
  EXPECT_NEAR(scheduler_.workers(now_).at(0).samples_per_second, 50 * 256, 500);
  const JobView view = *scheduler_.job(1, now_);
  EXPECT_NEAR(view.samples_per_second, 50 * 256, 500);
  EXPECT_NEAR(*view.eta_seconds, 1800 / 50.0, 2);
}

TEST_F(ScheduleTest, AResultThatComesWithReadySaysNothingOfASpeed) {
  add(1, spec(2000, 1));
  const WorkerId worker = join("a");
  ready(worker);
  finish_one(worker);
  EXPECT_EQ(held_[worker].size(), 2U);
  pass(0.5);
  finish_one(worker);
  EXPECT_LE(held_[worker].size(), 5U) << "four a second, as far as is known";
}

TEST_F(ScheduleTest, TheNextFrameBeginsWhereTheFirstHasNothingToGive) {
  add(1, spec(1, 1, {10, 20, 5}));
  const WorkerId worker = join("a");
  ASSERT_EQ(held_[worker].size(), 2);
  EXPECT_EQ(held_[worker][0].task.frame, 10);
  EXPECT_EQ(held_[worker][1].task.frame, 15);
  ready(worker);
  while (!held_[worker].empty()) {
    pass(0.5);
    finish_one(worker);
  }
  EXPECT_EQ(frames_, (std::vector<std::int32_t>{10, 15, 20}));
  EXPECT_EQ(finished_.size(), 1);
}

TEST_F(ScheduleTest, HigherPriorityGoesFirstAndCanBeChanged) {
  add(1, spec(10, 1));
  JobSpec urgent = spec(2, 1);
  urgent.priority = 5;
  add(2, urgent);
  const WorkerId a = join("a");
  EXPECT_EQ(held_[a].at(0).job, 2);
  EXPECT_EQ(held_[a].at(1).job, 2);
  const WorkerId b = join("b");
  EXPECT_EQ(held_[b].at(0).job, 1);
  add(3, spec(10, 1));
  take(scheduler_.set_priority(3, 7, now_));
  EXPECT_EQ(held_[join("c")].at(0).job, 3);
}

TEST_F(ScheduleTest, EqualJobsShareTheWorkersByTheTimeTheyCost) {
  add(1, spec(4000, 1));
  add(2, spec(4000, 1));
  std::vector<WorkerId> workers;
  for (const char* name : {"a", "b", "c", "d"}) workers.push_back(join(name));
  for (const WorkerId worker : workers) ready(worker, 1), ready(worker, 2);
  std::map<JobId, double> busy;
  // Job 2's tasks take three times as long.
  std::map<WorkerId, double> free_at;
  double clock = 0;
  const auto ends = [&](WorkerId worker) {
    return free_at[worker] + (held_[worker].at(0).job == 1 ? 0.1 : 0.3);
  };
  while (clock < 240) {
    const WorkerId next = *std::min_element(
        workers.begin(), workers.end(), [&](WorkerId a, WorkerId b) { return ends(a) < ends(b); });
    const JobId job = held_[next].at(0).job;
    ready(next, job);
    busy[job] += ends(next) - free_at[next];
    free_at[next] = ends(next);
    pass(free_at[next] - clock);
    clock = free_at[next];
    for (const WorkerId worker : workers) scheduler_.worker_heard(worker, now_);
    finish_one(next);
  }
  EXPECT_NEAR(busy[1] / (busy[1] + busy[2]), 0.5, 0.1);
}

TEST_F(ScheduleTest, JobsShareTheWorkersByWeightWhichFiveStepsOfPriorityDouble) {
  add(1, spec(4000, 1));
  JobSpec heavy = spec(4000, 1);
  heavy.priority = 10;
  add(2, heavy);
  std::vector<WorkerId> workers;
  for (const char* name : {"a", "b", "c", "d"}) workers.push_back(join(name));
  for (const WorkerId worker : workers) ready(worker, 1), ready(worker, 2);
  std::map<JobId, int> done;
  for (int i = 0; i < 600; ++i) {
    pass(0.2);
    for (const WorkerId worker : workers) {
      ready(worker, held_[worker].at(0).job);
      ++done[finish_one(worker).job];
    }
  }
  EXPECT_NEAR(done[2] / static_cast<double>(done[1] + done[2]), 0.8, 0.05);
}

TEST_F(ScheduleTest, AJobIsAtItsMostOfWorkersAtMost) {
  JobSpec two = spec(40, 1);
  two.max_workers = 2;
  add(1, two);
  std::vector<WorkerId> workers;
  for (const char* name : {"a", "b", "c", "d"}) workers.push_back(join(name));
  EXPECT_EQ(held_[workers[0]].size(), 2U);
  EXPECT_EQ(held_[workers[1]].size(), 2U);
  EXPECT_TRUE(held_[workers[2]].empty());
  EXPECT_TRUE(held_[workers[3]].empty());
  leave(workers[0], true);
  EXPECT_EQ(held_[workers[2]].size() + held_[workers[3]].size(), 2U) << "another takes its place";
  for (int i = 0; i < 200 && finished_.empty(); ++i) {
    pass(0.2);
    std::size_t at_it = 0;
    for (const WorkerId worker : workers) {
      scheduler_.worker_heard(worker, now_);
      if (held_[worker].empty()) continue;
      ++at_it;
      ready(worker);
      finish_one(worker);
    }
    EXPECT_LE(at_it, 2U);
  }
  EXPECT_EQ(finished_, std::vector<JobId>{1}) << "copies at the tail keep to it too";
}

TEST_F(ScheduleTest, AWorkerStaysWithTheJobThatItHasPrepared) {
  add(1, spec(1000, 1));
  add(2, spec(1000, 1));
  const WorkerId a = join("a");
  const WorkerId b = join("b");
  std::map<WorkerId, std::set<JobId>> served;
  for (int i = 0; i < 60; ++i) {
    pass(0.05);
    for (const WorkerId worker : {a, b}) {
      ready(worker, held_[worker].at(0).job);
      served[worker].insert(finish_one(worker).job);
    }
  }
  EXPECT_EQ(served[a], std::set<JobId>{1});
  EXPECT_EQ(served[b], std::set<JobId>{2});
}

TEST_F(ScheduleTest, APausedJobIsGrantedNoMoreUntilItIsResumed) {
  add(1, spec(10, 1));
  const WorkerId worker = join("a");
  ready(worker);
  take(scheduler_.pause_job(1, now_));
  pass(0.1);
  finish_one(worker);
  finish_one(worker);
  EXPECT_TRUE(held_[worker].empty());
  EXPECT_EQ(scheduler_.job(1, now_)->state, "paused");
  EXPECT_EQ(scheduler_.job(1, now_)->tasks_done, 2);
  take(scheduler_.resume_job(1, now_));
  EXPECT_GE(held_[worker].size(), 2);
}

TEST_F(ScheduleTest, ACancelledJobIsRevokedAndItsResultsAreStale) {
  add(1, spec(10, 1));
  const WorkerId worker = join("a");
  const auto grants = held_[worker];
  take(scheduler_.cancel_job(1, now_));
  EXPECT_EQ(revoked_.size(), 2);
  EXPECT_EQ(scheduler_.job(1, now_)->state, "cancelled");
  EXPECT_EQ(arrive(worker, grants[0]), Verdict::stale);
  EXPECT_TRUE(failed_.empty());
  scheduler_.forget_job(1);
  EXPECT_FALSE(scheduler_.job(1, now_));
  EXPECT_EQ(arrive(worker, grants[1]), Verdict::stale);
}

TEST_F(ScheduleTest, ADrainingWorkerFinishesWhatItHoldsAndGetsNoMore) {
  add(1, spec(10, 1));
  const WorkerId worker = join("a");
  ready(worker);
  take(scheduler_.drain_worker(worker, now_));
  pass(0.1);
  finish_one(worker);
  finish_one(worker);
  EXPECT_TRUE(held_[worker].empty());
  EXPECT_EQ(scheduler_.workers(now_).at(0).state, "draining");
}

TEST_F(ScheduleTest, AJobTakesWorkersOfItsFirstWorkersBuildOnly) {
  add(1, spec(10, 1));
  const WorkerId first = join("a", "one");
  EXPECT_TRUE(held_[join("b", "two")].empty());
  EXPECT_EQ(held_[join("c", "one")].size(), 2);
  EXPECT_EQ(scheduler_.job(1, now_)->build, digest_of("one"));
  JobSpec mixed = spec(10, 1);
  mixed.mixed = true;
  add(2, mixed);
  EXPECT_EQ(held_[2].size(), 2) << "a mixed job takes any";
  EXPECT_EQ(held_[first].size(), 2);
}

TEST_F(ScheduleTest, TheBuildIsFreeAgainWhenNothingOfItCameIn) {
  add(1, spec(10, 1));
  leave(join("a", "one"), true);
  EXPECT_EQ(held_[join("b", "two")].size(), 2);
  EXPECT_EQ(scheduler_.job(1, now_)->build, digest_of("two"));
}

TEST_F(ScheduleTest, LittleWorkIsSpreadOverManyWorkers) {
  std::vector<WorkerId> workers;
  for (const char* name : {"a", "b", "c", "d"}) workers.push_back(join(name));
  add(1, spec(4, 1));
  for (const WorkerId worker : workers) EXPECT_EQ(held_[worker].size(), 1);
}

TEST_F(ScheduleTest, ADecisionCostsTheSameForTenTasksAndForTenMillion) {
  // 3 million tiles of one pixel, 21 passes: 64 million tasks. What is not touched is not there.
  JobSpec huge = spec(1, 16 * 1024);
  huge.render.width = 3000;
  huge.render.height = 1000;
  huge.tile = 1;
  huge.pass = 1024;
  add(1, huge);
  EXPECT_GT(plans_[1]->tasks(), 60'000'000);
  const WorkerId worker = join("a");
  ready(worker);
  const auto began = std::chrono::steady_clock::now();
  for (int i = 0; i < 20'000; ++i) {
    pass(0.0001);
    finish_one(worker);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(5));
  EXPECT_EQ(scheduler_.job(1, now_)->tasks_done, 20'000);
}

}  // namespace
}  // namespace tessera::server
