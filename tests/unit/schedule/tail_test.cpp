// The tail: copies of late tasks for workers that would idle.
#include "tests/unit/schedule/schedule_fixture.hpp"

namespace tessera::server {
namespace {

class TailTest : public ScheduleTest {
 protected:
  /// Lets time pass in steps of a heartbeat; everyone is heard.
  void wait(double seconds) {
    for (double waited = 0; waited < seconds; waited += 0.5) {
      for (const WorkerView& worker : scheduler_.workers(now_))
        scheduler_.worker_heard(worker.id, now_);
      pass(std::min(0.5, seconds - waited));
    }
  }
  void join_both() {
    fast_ = join("fast");
    slow_ = join("slow");
    ready(fast_);
    ready(slow_);
  }
  /// `fast` renders all that is open at ten tasks a second; `slow` holds two and is silent on them.
  void reach_the_tail() {
    add(1, spec(6, 1));
    join_both();
    for (int i = 0; i < 4; ++i) {
      wait(0.1);
      finish_one(fast_);
    }
    ASSERT_EQ(scheduler_.job(1, now_)->tasks_done, 4);
    ASSERT_EQ(held_[slow_].size(), 2U);
  }
  WorkerId fast_ = 0, slow_ = 0;
};

TEST_F(TailTest, AnIdleWorkerIsGivenACopyTheFirstResultWinsAndTheLoserIsToldToStop) {
  reach_the_tail();
  ASSERT_EQ(held_[fast_].size(), 1U);
  for (int i = 0; i < 2; ++i) {
    const GrantLease copy = held_[fast_].at(0);
    const auto original =
        std::find_if(held_[slow_].begin(), held_[slow_].end(),
                     [&](const GrantLease& grant) { return grant.task == copy.task; });
    ASSERT_NE(original, held_[slow_].end());
    const GrantLease lost = *original;
    EXPECT_FALSE(lost.lease == copy.lease);
    wait(0.1);
    finish_one(fast_);
    EXPECT_TRUE(revoked_.contains(lost.lease));
    EXPECT_EQ(arrive(slow_, lost), Verdict::stale);
  }
  EXPECT_EQ(finished_, std::vector<JobId>{1});
}

TEST_F(TailTest, TheOriginalMayWinToo) {
  reach_the_tail();
  const GrantLease copy = held_[fast_].at(0);
  const GrantLease original =
      *std::find_if(held_[slow_].begin(), held_[slow_].end(),
                    [&](const GrantLease& grant) { return grant.task == copy.task; });
  EXPECT_EQ(arrive(slow_, original), Verdict::take);
  EXPECT_EQ(arrive(fast_, copy), Verdict::stale) << "the first result is being kept";
  durable(slow_, original);
  EXPECT_EQ(scheduler_.job(1, now_)->tasks_done, 5);
}

TEST_F(TailTest, NoCopyIsMadeWhileATaskIsOpen) {
  add(1, spec(40, 1));
  join_both();
  std::set<TaskId> granted;
  for (int i = 0; i < 38; ++i) {
    ASSERT_FALSE(held_[fast_].empty());
    EXPECT_TRUE(granted.insert(held_[fast_][0].task).second);
    for (const GrantLease& grant : held_[slow_]) EXPECT_NE(grant.task, held_[fast_][0].task);
    wait(0.1);
    finish_one(fast_);
  }
}

TEST_F(TailTest, NoCopyIsMadeThatWouldNotBeSooner) {
  add(1, spec(5, 1));
  join_both();
  // Alike: each task takes a second, and the last one has just been begun.
  wait(1);
  finish_one(fast_);
  finish_one(slow_);
  wait(1);
  finish_one(fast_);
  finish_one(slow_);
  ASSERT_EQ(held_[fast_].size() + held_[slow_].size(), 1U);
  wait(0.9);
  EXPECT_EQ(held_[fast_].size() + held_[slow_].size(), 1U);
  wait(10);  // … until it is late
  EXPECT_EQ(held_[fast_].size() + held_[slow_].size(), 2U);
}

TEST_F(TailTest, ProgressThatIsSlowMakesATaskLate) {
  add(1, spec(3, 1));
  join_both();
  wait(8);
  const GrantLease running = held_[slow_].at(0);
  take(scheduler_.worker_progress(slow_, {{running.lease, 0.4}}, now_));
  finish_one(fast_);
  finish_one(fast_);
  // The fast worker needs 8 s for two, the slow one 20 s for one: no gain worth a copy of 4 s …
  ASSERT_EQ(held_[slow_].size(), 1U);
  EXPECT_EQ(held_[fast_].size(), 1U) << "12 s are left of it, a copy takes 4";
  EXPECT_EQ(held_[fast_].at(0).task, running.task);
}

TEST_F(TailTest, ProgressFromBeforeTheLastResultSaysNothingOfTheSpeedSince) {
  add(1, spec(6, 1));
  slow_ = join("slow", "build", 2);
  ready(slow_);
  ASSERT_EQ(held_[slow_].size(), 2U);
  wait(4);
  take(scheduler_.worker_progress(
      slow_, {{held_[slow_][0].lease, 0.5}, {held_[slow_][1].lease, 0.5}}, now_));
  wait(8);
  finish_one(slow_);
  fast_ = join("fast");
  ready(fast_);
  for (int i = 0; i < 40 && finished_.empty(); ++i) {
    wait(0.5);
    if (!held_[fast_].empty()) finish_one(fast_);
  }
  EXPECT_EQ(finished_, std::vector<JobId>{1});
}

TEST_F(TailTest, ATaskIsOutThreeTimesAtMostAndOncePerWorker) {
  reach_the_tail();
  std::vector<WorkerId> others;
  for (const char* name : {"c", "d", "e", "f", "g"}) {
    others.push_back(join(name));
    ready(others.back());
  }
  wait(100);
  std::map<TaskId, std::set<WorkerId>> out;
  std::size_t leases = 0;
  for (const auto& [worker, grants] : held_) {
    leases += grants.size();
    for (const GrantLease& grant : grants) out[grant.task].insert(worker);
  }
  EXPECT_EQ(out.size(), 2U);
  EXPECT_EQ(leases, 6U);
  for (const auto& [task, workers] : out) EXPECT_EQ(workers.size(), 3U);
}

TEST_F(TailTest, WhenOneOfTwoIsLostTheOtherGoesOn) {
  reach_the_tail();
  const GrantLease copy = held_[fast_].at(0);
  leave(slow_, true);
  const WorkerId third = join("third");
  ready(third);
  for (const GrantLease& grant : held_[third]) EXPECT_NE(grant.task, copy.task);
  finish_one(fast_);
  EXPECT_EQ(scheduler_.job(1, now_)->tasks_done, 5);
  while (!held_[third].empty()) finish_one(third);
  EXPECT_EQ(finished_, std::vector<JobId>{1});
}

TEST_F(TailTest, ASuspectIsNotCopied) {
  add(1, spec(3, 1));
  const WorkerId victim = join("victim");
  ready(victim);
  const TaskId suspect = held_[victim][0].task;
  leave(victim, false);
  slow_ = join("slow");
  ready(slow_);
  ASSERT_EQ(held_[slow_].size(), 1U);
  ASSERT_EQ(held_[slow_][0].task, suspect);
  fast_ = join("fast");
  ready(fast_);
  while (!held_[fast_].empty()) {
    wait(0.1);
    EXPECT_NE(held_[fast_][0].task, suspect);
    finish_one(fast_);
  }
  wait(60);
  EXPECT_TRUE(held_[fast_].empty());
  finish_one(slow_);
  EXPECT_EQ(finished_, std::vector<JobId>{1});
}

TEST_F(TailTest, AWorkerThatIsLostWithACopyMakesItASuspect) {
  reach_the_tail();
  const TaskId task = held_[fast_].at(0).task;
  leave(fast_, false);
  leave(slow_, true);
  const WorkerId third = join("third");
  ready(third);
  ASSERT_EQ(held_[third].size(), 1U);
  EXPECT_EQ(held_[third][0].task, task) << "alone";
}

class WithoutCopies : public ScheduleTest {
 protected:
  static SchedulerSettings one_each() {
    SchedulerSettings settings;
    settings.copies_most = 1;
    return settings;
  }
  WithoutCopies() : ScheduleTest(one_each()) {}
};

TEST_F(WithoutCopies, AnIdleWorkerIdles) {
  add(1, spec(3, 1));
  const WorkerId fast = join("fast");
  const WorkerId slow = join("slow");
  ready(fast);
  ready(slow);
  pass(0.1);
  finish_one(fast);
  finish_one(fast);
  for (int i = 0; i < 20; ++i) {
    for (const WorkerId worker : {fast, slow}) scheduler_.worker_heard(worker, now_);
    pass(1);
  }
  EXPECT_TRUE(held_[fast].empty());
}

}  // namespace
}  // namespace tessera::server
