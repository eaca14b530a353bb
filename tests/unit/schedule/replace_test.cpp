// A job that is extended: another plan under the same id.
#include "tests/unit/schedule/schedule_fixture.hpp"

namespace tessera::server {
namespace {

class ReplacedJob : public ScheduleTest {
 protected:
  /// 2 tiles; passes end at 1, 4, 16, 20, and then at 1, 4, 16, 64, 100.
  std::vector<Digest> earlier;
  void replace() {
    earlier = {plans_[1]->digest};
    plans_[1] = std::make_shared<const JobPlan>(spec(2, 100));
    take(scheduler_.replace_job(1, plans_[1], now_, earlier));
  }
};

TEST_F(ReplacedJob, IsHandedOutOnceItIsResumedAndOnlyWhatIsOpen) {
  add(1, spec(2, 20));
  const WorkerId a = join("a");
  ready(a);
  ASSERT_FALSE(held_[a].empty());
  replace();
  EXPECT_TRUE(held_[a].empty()) << "its leases are revoked";
  scheduler_.restore_closed(1, {1, 0, 0});
  take(scheduler_.tile_folded(1, 1, 0, 1, now_));
  take(scheduler_.tile_folded(1, 1, 1, 3, now_));
  EXPECT_TRUE(held_[a].empty());
  EXPECT_EQ(scheduler_.job(1, now_)->state, "paused");
  take(scheduler_.resume_job(1, now_));
  ASSERT_GE(held_[a].size(), 2U);
  EXPECT_EQ(held_[a][0].task, (TaskId{1, 0, 1}));
  for (const GrantLease& grant : held_[a])
    EXPECT_GE(grant.task.pass, grant.task.tile == 0 ? 1U : 3U);
  EXPECT_TRUE(finished_.empty());
}

TEST_F(ReplacedJob, AnswersLateResultsOfItsEarlierPlanStaleAndHoldsThemAgainstNobody) {
  add(1, spec(2, 20));
  const WorkerId a = join("a");
  ready(a);
  const GrantLease late = held_[a].at(0);
  replace();
  take(scheduler_.resume_job(1, now_));
  for (int i = 0; i < 5; ++i)
    EXPECT_EQ(scheduler_.result_arrived(a, late.lease, 1, earlier[0], late.task, now_),
              Verdict::stale);
  pass(0);
  EXPECT_TRUE(dropped_.empty());
  EXPECT_NE(scheduler_.workers(now_).at(0).state, "quarantined");
  finish_one(a);
}

TEST_F(ReplacedJob, ThatHadEndedIsThereAgain) {
  add(1, spec(2, 1));
  const WorkerId a = join("a");
  ready(a);
  while (finished_.empty()) finish_one(a);
  scheduler_.forget_job(1);
  replace();
  take(scheduler_.tile_folded(1, 1, 0, 1, now_));
  take(scheduler_.tile_folded(1, 1, 1, 1, now_));
  take(scheduler_.resume_job(1, now_));
  EXPECT_EQ(held_[a].at(0).task, (TaskId{1, 0, 1}));
}

TEST_F(ReplacedJob, EarlierPlansAreKnownAfterARestartToo) {
  add(1, spec(2, 20));
  const WorkerId a = join("a");
  ready(a);
  const GrantLease late = held_[a].at(0);
  SchedulerSettings settings;
  settings.epoch = 2;
  Scheduler next(settings);
  const auto plan = std::make_shared<const JobPlan>(spec(2, 100));
  take(next.add_job(1, plan, now_, {plans_[1]->digest}));
  const auto joined = next.worker_joined({"a", "a", 1, digest_of("build")}, now_);
  EXPECT_EQ(next.result_arrived(joined.worker, late.lease, 1, plans_[1]->digest, late.task, now_),
            Verdict::stale);
  EXPECT_EQ(
      next.result_arrived(joined.worker, late.lease, 1, digest_of("no plan"), late.task, now_),
      Verdict::rejected);
}

}  // namespace
}  // namespace tessera::server
