// Who is suspected of what, and who is asked instead.
#include "tests/unit/schedule/schedule_fixture.hpp"

namespace tessera::server {
namespace {

class BlameTest : public ScheduleTest {
 protected:
  /// The worker process of this name, started again.
  WorkerId join_again(const std::string& name, const std::string& identity) {
    const WorkerInfo info{name, identity, 1, digest_of("build")};
    auto joined = scheduler_.worker_joined(info, now_);
    take(joined.actions);
    return joined.worker;
  }
  /// Time in steps of a second; everyone is heard.
  void wait(double seconds) {
    for (double waited = 0; waited < seconds; waited += 1) {
      for (const WorkerView& worker : scheduler_.workers(now_))
        scheduler_.worker_heard(worker.id, now_);
      pass(1);
    }
  }
  bool holds(WorkerId worker, const TaskId& task) {
    return std::any_of(held_[worker].begin(), held_[worker].end(),
                       [&](const GrantLease& grant) { return grant.task == task; });
  }
};

TEST_F(BlameTest, WorkersThatAreLostAtOnceWhilePreparingDoNotFailTheJob) {
  add(1, spec(20, 1));
  std::vector<WorkerId> workers;
  for (const char* name : {"a", "b", "c", "d"}) workers.push_back(join(name));
  wait(1);
  for (const WorkerId worker : workers) leave(worker, false);
  EXPECT_TRUE(failed_.empty());
  wait(5);
  const WorkerId again = join_again("a", "another a");
  ready(again);
  ASSERT_FALSE(held_[again].empty());
  while (!held_[again].empty()) finish_one(again);
  EXPECT_EQ(finished_, std::vector<JobId>{1});
}

TEST_F(BlameTest, WorkersThatAreLostInARowWhilePreparingFailTheJob) {
  add(1, spec(20, 1));
  for (const char* name : {"a", "b", "c"}) {
    EXPECT_TRUE(failed_.empty());
    const WorkerId worker = join(name);
    wait(1);
    leave(worker, false);
  }
  EXPECT_TRUE(failed_.contains(1));
}

TEST_F(BlameTest, NoLossWhilePreparingFailsAJobThatAWorkerHasPrepared) {
  add(1, spec(200, 1));
  const WorkerId good = join("good");
  ready(good);
  for (const char* name : {"a", "b", "c", "d"}) {
    const WorkerId worker = join(name);
    wait(1);
    leave(worker, false);
  }
  EXPECT_TRUE(failed_.empty());
}

TEST_F(BlameTest, ASuspectThatABusyWorkerKeepsIsNotForTheMachineThatItWasLostWith) {
  add(1, spec(4, 1));
  const WorkerId a = join("a");
  ready(a);
  const WorkerId b = join("b");
  ready(b);
  ASSERT_EQ(held_[b].size(), 2U);
  const TaskId suspect = held_[a].at(0).task;
  leave(a, false);
  wait(1);
  finish_one(b);  // from here on b keeps itself free for the suspect
  const WorkerId again = join_again("a", "another a");
  ready(again);
  ASSERT_FALSE(held_[again].empty()) << "what else there is";
  EXPECT_FALSE(holds(again, suspect));
  wait(1);
  while (!held_[again].empty() && !holds(again, suspect)) finish_one(again);
  EXPECT_FALSE(holds(again, suspect));
  while (!held_[b].empty() && !holds(b, suspect)) finish_one(b);
  EXPECT_TRUE(holds(b, suspect));
}

TEST_F(BlameTest, ASuspectThatWasKeptDoesNotBringAWorkerTooManyToItsJob) {
  JobSpec single = spec(20, 1);
  single.max_workers = 1;
  add(1, single);
  const WorkerId a = join("a");
  ready(a);
  ASSERT_EQ(held_[a].at(0).job, 1U);
  add(2, spec(2, 1));
  const WorkerId b = join("b");
  ready(b, 2);
  ASSERT_EQ(held_[b].size(), 2U);
  ASSERT_EQ(held_[b][1].job, 2U);
  const TaskId suspect = held_[a].at(0).task;
  leave(a, false);
  wait(1);
  finish_one(b);  // it is kept for the suspect of job 1
  const WorkerId c = join("c");
  ready(c);
  ASSERT_FALSE(held_[c].empty());
  ASSERT_EQ(held_[c][0].job, 1U);
  finish_one(b);
  EXPECT_TRUE(held_[b].empty()) << "c is at job 1, which takes one";
  for (int i = 0; i < 40 && !held_[c].empty(); ++i) {
    wait(1);
    finish_one(c);
  }
  EXPECT_EQ(finished_, (std::vector<JobId>{2, 1}));
  EXPECT_FALSE(holds(b, suspect));
}

TEST_F(BlameTest, WhatIsQueuedBehindATaskThatStandsStillDoesNotExpireWithIt) {
  add(1, spec(20, 1));
  const WorkerId a = join("a");
  ready(a);
  const GrantLease stuck = held_[a].at(0), behind = held_[a].at(1);
  wait(1);
  take(scheduler_.worker_progress(a, {{stuck.lease, 0.1}}, now_));
  for (int i = 0; i < 320 && revoked_.empty(); ++i) wait(1);
  EXPECT_TRUE(revoked_.contains(stuck.lease));
  EXPECT_FALSE(revoked_.contains(behind.lease));
  wait(5);
  EXPECT_FALSE(revoked_.contains(behind.lease));
  wait(310);
  EXPECT_TRUE(revoked_.contains(behind.lease)) << "in its own time";
}

TEST_F(BlameTest, ASceneThatNoJobUsesAnyMoreIsHeldAgainstNobody) {
  add(1, spec(20, 1));
  leave(join("a"), false);
  join("b");
  take(scheduler_.cancel_job(1, now_));
  const WorkerId again = join_again("a", "another a");
  add(2, spec(20, 1));
  EXPECT_FALSE(held_[again].empty());
}

TEST_F(BlameTest, ASceneThatAJobUsesIsNotForTheMachineThatItCrashed) {
  add(1, spec(20, 1));
  add(2, spec(20, 1));
  leave(join("a"), false);
  const WorkerId b = join("b");
  take(scheduler_.cancel_job(1, now_));
  EXPECT_TRUE(held_[join_again("a", "another a")].empty());
  EXPECT_FALSE(held_[b].empty());
}

TEST_F(BlameTest, AWorkerThatStandsStillIsNoOtherToAsk) {
  add(1, spec(20, 1));
  const WorkerId b = join("b");
  ready(b);
  const GrantLease stuck = held_[b].at(0);
  const WorkerId c = join("c");
  wait(1);
  leave(c, false);  // while it prepared: not again while b can
  const WorkerId again = join_again("c", "another c");
  EXPECT_TRUE(held_[again].empty());
  for (int i = 0; i < 320 && revoked_.empty(); ++i) {
    wait(1);
    take(scheduler_.worker_progress(b, {{stuck.lease, 0.1}}, now_));
  }
  ASSERT_TRUE(revoked_.contains(stuck.lease));
  EXPECT_FALSE(held_[again].empty());
}

}  // namespace
}  // namespace tessera::server
