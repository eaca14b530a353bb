// What is said of attempts that gave no result.
#include "tests/unit/schedule/schedule_fixture.hpp"

namespace tessera::server {
namespace {

using Outcome = AttemptFailed::Outcome;

class FailuresTest : public ScheduleTest {
 protected:
  FailuresTest() { add(1, spec(8, 4)); }
};

TEST_F(FailuresTest, what_a_lost_worker_ran_is_lost_and_what_waited_in_it_is_not) {
  const WorkerId worker = join("a");
  const Instant granted = now_;
  ready(worker);
  ASSERT_GE(held_[worker].size(), 2U);
  const GrantLease running = held_[worker].front();
  pass(0.5);
  leave(worker, false);
  ASSERT_EQ(failures_.size(), 1U);
  const AttemptFailed& failure = failures_.front();
  EXPECT_EQ(failure.job, 1U);
  EXPECT_EQ(failure.task, running.task);
  EXPECT_EQ(failure.lease, running.lease);
  EXPECT_EQ(failure.worker, worker);
  EXPECT_EQ(failure.worker_name, "a");
  EXPECT_EQ(failure.outcome, Outcome::lost);
  EXPECT_EQ(failure.reason, "its connection ended without a word");
  EXPECT_EQ(failure.granted, granted);
}

TEST_F(FailuresTest, a_clean_end_a_drain_and_a_revocation_are_no_failures) {
  const WorkerId leaves = join("a"), drains = join("b"), barred = join("c");
  for (const WorkerId worker : {leaves, drains, barred}) ready(worker);
  leave(leaves, true);
  take(scheduler_.drain_worker(drains, now_));
  leave(drains, false);
  take(scheduler_.quarantine("c", "its fan is broken", now_));
  take(scheduler_.cancel_job(1, now_));
  EXPECT_TRUE(failures_.empty());
}

TEST_F(FailuresTest, a_silent_worker_is_lost_with_that_reason) {
  const WorkerId worker = join("a");
  ready(worker);
  pass(10);
  ASSERT_EQ(failures_.size(), 1U);
  EXPECT_EQ(failures_.front().outcome, Outcome::lost);
  EXPECT_EQ(failures_.front().reason, "nothing was heard of it for too long");
}

TEST_F(FailuresTest, a_loss_while_the_scene_is_built_names_no_task) {
  const WorkerId worker = join("a");
  leave(worker, false);
  ASSERT_EQ(failures_.size(), 1U);
  EXPECT_EQ(failures_.front().outcome, Outcome::lost);
  EXPECT_FALSE(failures_.front().task.has_value());
  EXPECT_TRUE(failures_.front().granted.has_value());
}

TEST_F(FailuresTest, a_task_that_stands_still_is_stalled) {
  const WorkerId worker = join("a");
  ready(worker);
  const GrantLease running = held_[worker].front();
  take(scheduler_.worker_progress(worker, {{running.lease, 0.1}}, now_));
  for (int second = 0; second < 400 && failures_.empty(); ++second) {
    scheduler_.worker_heard(worker, now_);
    pass(1);
  }
  ASSERT_EQ(failures_.size(), 1U);
  EXPECT_EQ(failures_.front().outcome, Outcome::stalled);
  EXPECT_EQ(failures_.front().task, running.task);
  EXPECT_EQ(failures_.front().reason, "no progress for too long");
}

TEST_F(FailuresTest, while_nothing_is_taken_in_from_a_worker_nothing_that_it_runs_stands_still) {
  const WorkerId worker = join("a");
  ready(worker);
  for (int i = 0; i < 4; ++i) {
    pass(0.1);
    finish_one(worker);
  }
  const GrantLease running = held_[worker].at(0);
  take(scheduler_.worker_progress(worker, {{running.lease, 0.1}}, now_));
  const Duration still = settings_.stall_least + std::chrono::seconds(1);
  for (int times = 0; times < 3; ++times) {
    now_ += still;  // without a tick: nothing of this process ran
    scheduler_.excuse_worker(worker, now_);
    pass(0);
  }
  EXPECT_TRUE(failures_.empty());
  EXPECT_TRUE(revoked_.empty());
  EXPECT_TRUE(dropped_.empty());
  EXPECT_EQ(scheduler_.workers(now_).at(0).state, "rendering");
  const Instant excused = now_;
  while (failures_.empty() && now_ - excused < 2 * still) {
    scheduler_.worker_heard(worker, now_);
    pass(1);
  }
  EXPECT_EQ(failures_.size(), 1U) << "what stands still from there on is its own";
  EXPECT_GE(now_ - excused, settings_.stall_least);
}

TEST_F(FailuresTest, while_nothing_is_taken_in_from_a_worker_its_preparation_does_not_stand_still) {
  const WorkerId worker = join("a");
  take(scheduler_.worker_preparing(worker, 1, 0.5, now_));
  now_ += settings_.preparation + std::chrono::seconds(1);
  scheduler_.excuse_worker(worker, now_);
  pass(0);
  EXPECT_TRUE(failures_.empty());
  EXPECT_TRUE(revoked_.empty());
}

TEST_F(FailuresTest, what_a_worker_says_is_the_reason) {
  const WorkerId worker = join("a");
  ready(worker);
  const GrantLease running = held_[worker].front();
  take(scheduler_.worker_failed(worker, 1, running.lease, "no memory", now_));
  take(scheduler_.worker_failed(worker, 1, std::nullopt, "scene.json:3:1: no such file", now_));
  ASSERT_EQ(failures_.size(), 2U);
  EXPECT_EQ(failures_[0].outcome, Outcome::failed);
  EXPECT_EQ(failures_[0].task, running.task);
  EXPECT_EQ(failures_[0].reason, "no memory");
  EXPECT_FALSE(failures_[1].task.has_value());
  EXPECT_EQ(failures_[1].reason, "scene.json:3:1: no such file");
}

TEST_F(FailuresTest,
       a_result_that_is_not_what_was_asked_is_invalid_and_one_that_cannot_be_kept_is_not) {
  const WorkerId worker = join("a");
  ready(worker);
  const GrantLease first = held_[worker][0], second = held_[worker][1];
  ASSERT_EQ(arrive(worker, first), Verdict::take);
  take(scheduler_.result_invalid(worker, first.lease, 1, first.task, "no channel R", now_));
  ASSERT_EQ(arrive(worker, second), Verdict::take);
  take(scheduler_.result_invalid(worker, second.lease, 1, second.task, "", now_));
  ASSERT_EQ(failures_.size(), 1U);
  EXPECT_EQ(failures_.front().outcome, Outcome::invalid);
  EXPECT_EQ(failures_.front().task, first.task);
  EXPECT_EQ(failures_.front().reason, "no channel R");
}

}  // namespace
}  // namespace tessera::server
