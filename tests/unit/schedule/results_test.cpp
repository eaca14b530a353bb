// Results: what is taken, what is stale, what is rejected; and the lease numbers that decide it.
#include "server/schedule/lease_numbers.hpp"
#include "tests/unit/schedule/schedule_fixture.hpp"

namespace tessera::server {
namespace {

TEST_F(ScheduleTest, AResultThatCouldNotBeKeptIsNobodysFault) {
  add(1, spec(1, 1));
  const WorkerId a = join("a");
  ready(a);
  for (int i = 0; i < 5; ++i) {
    pass(0.5);
    const GrantLease grant = held_[a].at(0);
    held_[a].clear();
    ASSERT_EQ(arrive(a, grant), Verdict::take);
    take(scheduler_.result_invalid(a, grant.lease, 1, grant.task, "", now_));
    ASSERT_EQ(held_[a].size(), 1) << "out again at once";
  }
  EXPECT_TRUE(dropped_.empty());
  finish_one(a);
  EXPECT_EQ(finished_.size(), 1);
}

TEST_F(ScheduleTest, ASecondResultIsStaleAsSoonAsTheFirstIsBeingKept) {
  add(1, spec(2, 1));
  const WorkerId a = join("a");
  ready(a);
  const GrantLease grant = held_[a].at(0);
  EXPECT_EQ(arrive(a, grant), Verdict::take);
  EXPECT_EQ(arrive(a, grant), Verdict::stale);
  durable(a, grant);
  EXPECT_EQ(arrive(a, grant), Verdict::stale);
  EXPECT_EQ(scheduler_.job(1, now_)->tasks_done, 1);
}

TEST_F(ScheduleTest, AnInvalidResultSendsTheTaskElsewhereAndThreeEndTheWorker) {
  add(1, spec(20, 1));
  const WorkerId liar = join("liar");
  const WorkerId b = join("b");
  ready(liar);
  ready(b);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(dropped_.empty());
    pass(2);
    for (const WorkerId worker : {liar, b}) scheduler_.worker_heard(worker, now_);
    const GrantLease grant = held_[liar].at(0);
    held_[liar].erase(held_[liar].begin());
    ASSERT_EQ(arrive(liar, grant), Verdict::take);
    take(scheduler_.result_invalid(liar, grant.lease, 1, grant.task, "NaN", now_));
    EXPECT_EQ(arrive(liar, grant), Verdict::stale) << "the same bytes are not looked at again";
    pass(0.5);
    while (!held_[b].empty() && held_[b][0].task != grant.task) finish_one(b);
    ASSERT_FALSE(held_[b].empty()) << "the task is out again, elsewhere";
    finish_one(b);
  }
  EXPECT_EQ(dropped_, std::vector<WorkerId>{liar});
  scheduler_.worker_left(liar, false, now_);
  const WorkerId again = join("liar");
  EXPECT_TRUE(held_[again].empty());
  EXPECT_EQ(again, liar);
  EXPECT_EQ(scheduler_.workers(now_).at(0).state, "quarantined");
  EXPECT_TRUE(failed_.empty());
}

TEST_F(ScheduleTest, AResultThatWasNeverGrantedToTheIdentityIsRejected) {
  add(1, spec(20, 1));
  const WorkerId a = join("a");
  const WorkerId b = join("b");
  const GrantLease grant = held_[a].at(0);
  EXPECT_EQ(arrive(b, grant), Verdict::rejected) << "another's lease";
  GrantLease other = grant;
  other.task.tile = 15;
  EXPECT_EQ(arrive(a, other), Verdict::rejected) << "another task";
  GrantLease made_up = grant;
  made_up.lease.number += 1;
  EXPECT_EQ(arrive(a, made_up), Verdict::rejected);
  EXPECT_EQ(
      scheduler_.result_arrived(a, grant.lease, 1, digest_of("another plan"), grant.task, now_),
      Verdict::rejected);
  EXPECT_LE(*scheduler_.next_deadline(), now_);
  pass(0);
  EXPECT_EQ(dropped_, std::vector<WorkerId>{a}) << "three times is enough";
}

TEST_F(ScheduleTest, TheSameIdentityKeepsItsIdUnlessItsOldConnectionHasNotEnded) {
  const WorkerId first = join("a");
  leave(first, false);
  EXPECT_EQ(join("a"), first);
  const WorkerId second = join("a");
  EXPECT_NE(second, first);
  EXPECT_EQ(dropped_, std::vector<WorkerId>{first});
  leave(first, false);  // the old connection's end comes late
  ASSERT_EQ(scheduler_.workers(now_).size(), 1);
  EXPECT_EQ(scheduler_.workers(now_)[0].id, second);
  leave(second, true);
  EXPECT_EQ(join("a"), second);
}

TEST_F(ScheduleTest, AfterARestartOldLeasesAreTakenAndClosedTasksAreNotGrantedAgain) {
  add(1, spec(3, 4));
  const WorkerId a = join("a");
  ready(a);
  const GrantLease old = held_[a].at(1);
  EXPECT_EQ(old.task, (TaskId{1, 1, 0}));
  finish_one(a);

  SchedulerSettings settings;
  settings.epoch = 2;
  Scheduler next(settings);
  take(next.add_job(1, plans_[1], now_));
  next.restore_closed(1, {1, 0, 0});
  next.restore_build(1, digest_of("build"));
  take(next.tile_folded(1, 1, 0, 1, now_));
  held_.clear();
  EXPECT_TRUE(next.worker_joined({"x", "x", 1, digest_of("other build")}, now_).actions.empty());
  auto joined = next.worker_joined({"a", "a", 1, digest_of("build")}, now_);
  for (const Action& action : joined.actions) {
    const auto* grant = std::get_if<GrantLease>(&action);
    ASSERT_NE(grant, nullptr);
    EXPECT_EQ(grant->lease.epoch, 2);
    EXPECT_NE(grant->task, (TaskId{1, 0, 0}));
  }
  EXPECT_EQ(next.result_arrived(joined.worker, old.lease, 1, plans_[1]->digest, old.task, now_),
            Verdict::take);
  EXPECT_EQ(next.job(1, now_)->tasks_done, 1);
}

TEST(LeaseNumbers, AreSipHashAsItsAuthorsPublishedIt) {
  std::array<std::uint8_t, 16> key{};
  std::vector<std::uint8_t> message(15);
  for (std::size_t i = 0; i < key.size(); ++i) key[i] = static_cast<std::uint8_t>(i);
  for (std::size_t i = 0; i < message.size(); ++i) message[i] = static_cast<std::uint8_t>(i);
  EXPECT_EQ(siphash(key, message), 0xa129ca6149be45e5ULL);
}

TEST(LeaseNumbers, OfTheFutureOrOfAnotherKeyWereNotGranted) {
  LeaseNumbers numbers(3, {1});
  const TaskId task{1, 2, 3};
  const LeaseId lease = numbers.next("a", 1, task);
  EXPECT_TRUE(numbers.granted(lease, "a", 1, task));
  EXPECT_FALSE(numbers.granted(lease, "a", 2, task));
  EXPECT_FALSE(LeaseNumbers(3, {1}).granted(lease, "a", 1, task)) << "it has granted none yet";
  EXPECT_FALSE(LeaseNumbers(2, {1}).granted(lease, "a", 1, task));
  EXPECT_TRUE(LeaseNumbers(4, {1}).granted(lease, "a", 1, task));
  EXPECT_FALSE(LeaseNumbers(4, {2}).granted(lease, "a", 1, task));
}

}  // namespace
}  // namespace tessera::server
