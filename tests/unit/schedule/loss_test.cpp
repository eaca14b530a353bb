// Workers that are lost, fail or lie, and what is held against whom.
#include <gmock/gmock.h>

#include "tests/unit/schedule/schedule_fixture.hpp"

namespace tessera::server {
namespace {

using ::testing::HasSubstr;

TEST_F(ScheduleTest, ALostConnectionPutsItsTasksOutAgainAtOnce) {
  add(1, spec(2, 1));
  const WorkerId a = join("a");
  ready(a);
  const WorkerId b = join("b");
  EXPECT_TRUE(held_[b].empty());
  leave(a, true);
  EXPECT_EQ(held_[b].size(), 2);
}

TEST_F(ScheduleTest, ASilentWorkerIsDroppedAndItsWorkIsOutWithinFiveSeconds) {
  add(1, spec(2, 1));
  const WorkerId a = join("a");
  ready(a);
  const WorkerId b = join("b");
  double waited = 0;
  while (dropped_.empty() && waited < 10) {
    ASSERT_TRUE(scheduler_.next_deadline());
    pass(0.5);
    waited += 0.5;
    scheduler_.worker_heard(b, now_);
  }
  EXPECT_EQ(dropped_, std::vector<WorkerId>{a});
  EXPECT_LT(waited, 5);
  EXPECT_EQ(held_[b].size(), 1) << "the one that ran is a suspect and runs alone";
  finish_one(b);
  EXPECT_EQ(held_[b].size(), 1);
}

TEST_F(ScheduleTest, WhatIsHeardKeepsAWorker) {
  add(1, spec(2, 1));
  const WorkerId a = join("a");
  for (int i = 0; i < 20; ++i) {
    pass(1);
    scheduler_.worker_heard(a, now_);
  }
  EXPECT_TRUE(dropped_.empty());
}

TEST_F(ScheduleTest, AnExpiredLeaseIsOutAgainOnceItsWorkerHasLetGoOfIt) {
  add(1, spec(2, 1));
  const WorkerId a = join("a");
  ready(a);
  const std::vector<GrantLease> before = held_[a];
  ASSERT_EQ(before.size(), 2U);
  const auto progress = [&](const std::vector<std::pair<LeaseId, double>>& running) {
    take(scheduler_.worker_progress(a, running, now_));
  };
  const auto state = [&] { return scheduler_.workers(now_).at(0).state; };
  for (double waited = 0; waited < 299; waited += 1) {
    progress({{before[0].lease, 0}});
    pass(1);
  }
  EXPECT_EQ(state(), "rendering");
  EXPECT_TRUE(revoked_.empty());
  pass(2);
  EXPECT_EQ(revoked_, std::set<LeaseId>{before[0].lease});
  EXPECT_TRUE(dropped_.empty());
  EXPECT_EQ(state(), "stalled");
  // What was on its way before it heard of the end.
  progress({{before[0].lease, 0}});
  pass(1);
  EXPECT_EQ(state(), "stalled");
  EXPECT_EQ(held_[a].size(), 1U) << "what is queued behind it";
  progress({});
  EXPECT_EQ(state(), "rendering");
  for (int i = 0; i < 2; ++i) {
    ASSERT_FALSE(held_[a].empty()) << i;
    EXPECT_FALSE(held_[a][0].lease == before[0].lease);
    finish_one(a);
  }
  EXPECT_EQ(finished_, std::vector<JobId>{1});
}

TEST_F(ScheduleTest, AResultOfAnExpiredLeaseAlsoShowsLife) {
  add(1, spec(2, 1));
  const WorkerId a = join("a");
  ready(a);
  const GrantLease late = held_[a].at(0);
  for (double waited = 0; waited < 301; waited += 1) {
    scheduler_.worker_heard(a, now_);
    pass(1);
  }
  ASSERT_EQ(scheduler_.workers(now_).at(0).state, "stalled");
  EXPECT_EQ(arrive(a, late), Verdict::take);
  durable(a, late);
  EXPECT_EQ(scheduler_.workers(now_).at(0).state, "rendering");
  EXPECT_EQ(held_[a].size(), 1U);
}

TEST_F(ScheduleTest, AJobThatCannotGoOnSaysWhatItWaitsFor) {
  add(1, spec(20, 1));
  const auto waits = [&] { return scheduler_.job(1, now_)->waiting_for; };
  EXPECT_EQ(waits(), "no worker is connected");
  const WorkerId a = join("a", "one");
  EXPECT_EQ(waits(), "");
  ready(a);
  finish_one(a);  // from here on the build stands
  leave(a, true);
  EXPECT_EQ(waits(), "no worker is connected");
  const WorkerId b = join("b", "two");
  join("c", "two");
  EXPECT_EQ(waits(), "its build is " + digest_of("one").hex().substr(0, 12) +
                         "; the 2 connected workers are of other builds");
  const WorkerId d = join("d", "one");
  EXPECT_EQ(waits(), "");
  take(scheduler_.worker_failed(d, 1, std::nullopt, "the scene is too large", now_));
  EXPECT_EQ(waits(),
            "preparation failed on every connected worker of its build: the scene is too large");
  leave(b, true);
  pass(1);  // its rest is over: it is asked again
  EXPECT_EQ(waits(), "");
  take(scheduler_.drain_worker(d, now_));
  for (const GrantLease& held : std::vector(held_[d]))
    take(scheduler_.worker_failed(d, 1, held.lease, "broken", now_));
  EXPECT_EQ(waits(), "every worker of its build is draining or quarantined");
  take(scheduler_.pause_job(1, now_));
  EXPECT_EQ(waits(), "");
}

TEST_F(ScheduleTest, ASuspectRunsAloneAndThreeDeathsAloneFailTheJob) {
  add(1, spec(20, 1));
  TaskId poison{};
  for (int death = 0; death < 4; ++death) {
    ASSERT_TRUE(failed_.empty()) << death;
    const WorkerId worker = join("victim " + std::to_string(death));
    ready(worker);
    if (death == 0) {
      EXPECT_EQ(held_[worker].size(), 2);
      poison = held_[worker][0].task;
    } else {
      ASSERT_EQ(held_[worker].size(), 1);
      EXPECT_EQ(held_[worker][0].task, poison);
    }
    leave(worker, false);
  }
  ASSERT_TRUE(failed_.contains(1));
  EXPECT_THAT(failed_[1], HasSubstr(text_of(poison)));
  EXPECT_EQ(scheduler_.job(1, now_)->state, "failed");
  EXPECT_THAT(scheduler_.job(1, now_)->error, HasSubstr("3 workers"));
}

TEST_F(ScheduleTest, ABusyWorkerIsKeptFreeForASuspect) {
  add(1, spec(200, 1));
  const WorkerId a = join("a");
  ready(a);
  const WorkerId b = join("b");
  ready(b);
  const TaskId suspect = held_[a][0].task;
  leave(a, false);
  pass(0.4);
  finish_one(b);
  finish_one(b);
  ASSERT_EQ(held_[b].size(), 1);
  EXPECT_EQ(held_[b][0].task, suspect);
  pass(0.4);
  finish_one(b);
  EXPECT_GE(held_[b].size(), 2) << "after the suspect all is as before";
}

TEST_F(ScheduleTest, CleanEndsNeverCount) {
  add(1, spec(20, 1));
  for (int i = 0; i < 8; ++i) {
    const WorkerId worker = join("w" + std::to_string(i));
    ready(worker);
    EXPECT_EQ(held_[worker].size(), 2);
    leave(worker, true);
  }
  EXPECT_TRUE(failed_.empty());
}

TEST_F(ScheduleTest, AWorkerThatComesBackDidNotDieOfItsTasks) {
  add(1, spec(1, 1));
  for (int i = 0; i < 8; ++i) {
    const WorkerId worker = join("the same");
    ready(worker);
    ASSERT_EQ(held_[worker].size(), 1);
    leave(worker, false);
  }
  EXPECT_TRUE(failed_.empty());
}

TEST_F(ScheduleTest, ErrorsOfThreeDifferentWorkersFailTheJob) {
  add(1, spec(1, 1));
  std::vector<WorkerId> workers;
  for (const char* name : {"a", "b", "c"}) workers.push_back(join(name));
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(failed_.empty());
    const auto holder =
        std::find_if(workers.begin(), workers.end(), [&](WorkerId w) { return !held_[w].empty(); });
    ASSERT_NE(holder, workers.end());
    const WorkerId worker = *holder;
    workers.erase(holder);
    const LeaseId lease = held_[worker][0].lease;
    held_[worker].clear();
    take(scheduler_.worker_failed(worker, 1, lease, "no such texture", now_));
  }
  EXPECT_THAT(failed_[1], HasSubstr("no such texture"));
}

TEST_F(ScheduleTest, AnErrorSendsTheTaskToAnotherWorker) {
  add(1, spec(1, 1));
  const WorkerId a = join("a");
  const WorkerId b = join("b");
  const LeaseId lease = held_[a].at(0).lease;
  held_[a].clear();
  take(scheduler_.worker_failed(a, 1, lease, "out of memory", now_));
  ASSERT_EQ(held_[b].size(), 1);
  pass(0.1);
  finish_one(b);
  EXPECT_EQ(finished_.size(), 1);
}

TEST_F(ScheduleTest, TheOnlyWorkerTriesThreeTimesWithPauses) {
  add(1, spec(1, 1));
  const WorkerId a = join("a");
  int tries = 0;
  for (int i = 0; i < 100 && failed_.empty(); ++i) {
    pass(0.1);
    scheduler_.worker_heard(a, now_);
    if (held_[a].empty()) continue;
    const LeaseId lease = held_[a][0].lease;
    held_[a].clear();
    take(scheduler_.worker_failed(a, 1, lease, "broken", now_));
    EXPECT_TRUE(held_[a].empty()) << "not at once";
    ++tries;
  }
  EXPECT_EQ(tries, 3);
  EXPECT_TRUE(failed_.contains(1));
}

TEST_F(ScheduleTest, AWorkerThatCannotPrepareGetsNoMoreOfTheJobAndThreeFailIt) {
  add(1, spec(20, 1));
  const WorkerId d = join("d");
  for (const char* name : {"a", "b", "c"}) {
    ASSERT_TRUE(failed_.empty());
    const WorkerId worker = join(name);
    EXPECT_EQ(held_[worker].size(), 2);
    held_[worker].clear();
    take(scheduler_.worker_failed(worker, 1, std::nullopt, "mesh.obj is lacking", now_));
    pass(1);
    for (const WorkerId other : {worker, d}) scheduler_.worker_heard(other, now_);
    EXPECT_TRUE(held_[worker].empty());
  }
  EXPECT_THAT(failed_[1], HasSubstr("mesh.obj is lacking"));
}

TEST_F(ScheduleTest, AJobThatNoConnectedWorkerCanPrepareFailsInsteadOfWaiting) {
  add(1, spec(20, 1));
  const WorkerId a = join("a");
  for (int i = 0; i < 200 && failed_.empty(); ++i) {
    if (!held_[a].empty()) {
      held_[a].clear();
      take(scheduler_.worker_failed(a, 1, std::nullopt, "no", now_));
    }
    pass(0.1);
    scheduler_.worker_heard(a, now_);
  }
  EXPECT_TRUE(failed_.contains(1));
}

TEST_F(ScheduleTest, LeasesThatStandStillExpireAndAreStillTakenWhenTheyCome) {
  add(1, spec(1, 1));
  const WorkerId a = join("a");
  ready(a);
  const GrantLease grant = held_[a].at(0);
  const WorkerId b = join("b");
  for (int i = 0; i < 310; ++i) {
    pass(1);
    for (const WorkerId worker : {a, b}) scheduler_.worker_heard(worker, now_);
    take(scheduler_.worker_progress(a, {{grant.lease, 0.5}}, now_));
  }
  EXPECT_TRUE(revoked_.contains(grant.lease));
  ASSERT_EQ(held_[b].size(), 1);
  const LeaseId second = held_[b][0].lease;
  EXPECT_EQ(arrive(a, grant), Verdict::take);
  durable(a, grant);
  EXPECT_TRUE(revoked_.contains(second)) << "the loser is told to stop";
  fold(1, grant.task);
  EXPECT_EQ(finished_.size(), 1);
}

TEST_F(ScheduleTest, ATaskThatStandsStillExpiresAloneAndByWhatItShouldTake) {
  add(1, spec(20, 1));
  const WorkerId a = join("a", "build", 4);
  ready(a);
  for (int i = 0; i < 4; ++i) {
    pass(2);
    scheduler_.worker_heard(a, now_);
    finish_one(a);
  }
  ASSERT_EQ(held_[a].size(), 2U);
  const GrantLease stuck = held_[a][0], going = held_[a][1];
  double waited = 0;
  for (; waited < 100 && revoked_.empty(); ++waited) {
    pass(1);
    take(scheduler_.worker_progress(a, {{stuck.lease, 0.3}, {going.lease, waited / 100}}, now_));
  }
  EXPECT_NEAR(waited, 41, 2) << "twenty times two seconds";
  EXPECT_TRUE(revoked_.contains(stuck.lease));
  EXPECT_FALSE(revoked_.contains(going.lease));
  // It hears that the lease is over, and goes on with the other.
  take(scheduler_.worker_progress(a, {{going.lease, 0.6}}, now_));
  EXPECT_EQ(held_[a].at(0).task, going.task);
  finish_one(a);
  ASSERT_FALSE(held_[a].empty());
  EXPECT_EQ(held_[a].at(0).task, stuck.task) << "alone: it is a suspect";
}

TEST_F(ScheduleTest, ARenderedTileThatIsOnItsWayDoesNotStandStill) {
  add(1, spec(20, 1));
  const WorkerId a = join("a");
  ready(a);
  for (int i = 0; i < 4; ++i) {
    pass(0.1);
    finish_one(a);
  }
  take(scheduler_.worker_progress(a, {{held_[a].at(0).lease, 0.9}}, now_));
  for (int i = 0; i < 120; ++i) {
    take(scheduler_.worker_progress(a, {}, now_));
    pass(1);
  }
  EXPECT_TRUE(revoked_.empty());
}

TEST_F(ScheduleTest, ProgressKeepsALeaseAlive) {
  add(1, spec(1, 1));
  const WorkerId a = join("a");
  ready(a);
  for (int i = 0; i < 1000; ++i) {
    pass(1);
    take(scheduler_.worker_progress(a, {{held_[a].at(0).lease, i / 1000.0}}, now_));
  }
  EXPECT_TRUE(revoked_.empty());
}

}  // namespace
}  // namespace tessera::server
