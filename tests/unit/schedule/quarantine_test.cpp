// Workers that are kept away from work, by the scheduler or by a person.
#include <gmock/gmock.h>

#include "tests/unit/schedule/schedule_fixture.hpp"

namespace tessera::server {
namespace {

using ::testing::HasSubstr;

class QuarantineTest : public ScheduleTest {
 protected:
  WorkerView view(WorkerId worker) {
    for (const WorkerView& one : scheduler_.workers(now_))
      if (one.id == worker) return one;
    return {};
  }
  void fail_one(WorkerId worker) {
    const GrantLease grant = held_[worker].at(0);
    held_[worker].erase(held_[worker].begin());
    take(scheduler_.worker_failed(worker, grant.job, grant.lease, "out of memory", now_));
  }
  void render_one(WorkerId worker) {
    for (const WorkerView& one : scheduler_.workers(now_)) scheduler_.worker_heard(one.id, now_);
    pass(0.6);
    finish_one(worker);
  }
  /// Everyone is heard; errors' rests go by.
  void rest() {
    for (int i = 0; i < 4; ++i) {
      for (const WorkerView& one : scheduler_.workers(now_)) scheduler_.worker_heard(one.id, now_);
      pass(0.5);
    }
  }
  /// It fails on whatever it is given, until that is of job 2.
  void fail_until_job_2(WorkerId worker) {
    for (int i = 0; i < 40 && (held_[worker].empty() || held_[worker][0].job == 1); ++i) {
      if (!held_[worker].empty()) fail_one(worker);
      rest();
    }
  }
  /// `bad` holds leases of jobs 1 and then 2; `good` has rendered a task of both.
  void two_jobs() {
    add(1, spec(40, 1));
    good_ = join("good");
    ready(good_, 1);
    render_one(good_);
    bad_ = join("bad");
    JobSpec urgent = spec(40, 1);
    urgent.priority = 60;
    add(2, urgent);
    while (held_[good_].at(0).job == 1) render_one(good_);
    ready(good_, 2);
    render_one(good_);
    ASSERT_EQ(held_[bad_].at(0).job, 1U);
  }
  WorkerId good_ = 0, bad_ = 0;
};

TEST_F(QuarantineTest, AWorkerThatFailsOnTwoJobsThatOthersRenderGetsNoMoreAndItIsSaidWhy) {
  two_jobs();
  fail_one(bad_);
  EXPECT_EQ(view(bad_).reason, "");
  fail_until_job_2(bad_);
  ASSERT_FALSE(held_[bad_].empty());
  ASSERT_EQ(held_[bad_][0].job, 2U);
  fail_one(bad_);
  EXPECT_EQ(view(bad_).state, "quarantined");
  EXPECT_THAT(view(bad_).reason, HasSubstr("2 jobs"));
  EXPECT_THAT(view(bad_).reason, HasSubstr("out of memory"));
  while (!held_[bad_].empty()) fail_one(bad_);
  rest();
  EXPECT_TRUE(held_[bad_].empty());
  leave(bad_, true);
  EXPECT_EQ(view(join("bad")).state, "quarantined") << "also when it comes back";
  take(scheduler_.release("bad", now_));
  EXPECT_FALSE(held_[bad_].empty());
  EXPECT_EQ(view(bad_).reason, "");
}

TEST_F(QuarantineTest, AGoodResultInBetweenShowsThatTheWorkerIsWell) {
  two_jobs();
  fail_one(bad_);
  ready(bad_, 1);
  render_one(bad_);
  rest();
  while (!held_[bad_].empty() && held_[bad_][0].job == 1) render_one(bad_);
  ASSERT_EQ(held_[bad_].at(0).job, 2U);
  fail_one(bad_);
  EXPECT_NE(view(bad_).state, "quarantined");
}

TEST_F(QuarantineTest, JobsThatNobodyRendersAreNotHeldAgainstAWorker) {
  add(1, spec(40, 1));
  const WorkerId a = join("a");
  join("b");
  fail_one(a);
  fail_one(a);
  take(scheduler_.pause_job(1, now_));
  add(2, spec(40, 1));
  rest();
  ASSERT_FALSE(held_[a].empty());
  ASSERT_EQ(held_[a][0].job, 2U);
  fail_one(a);
  EXPECT_NE(view(a).state, "quarantined");
}

TEST_F(QuarantineTest, ASceneIsNotGivenTwiceToAWorkerThatItCrashed) {
  add(1, spec(40, 1));
  const auto start = [&](const std::string& process, const std::string& name) {
    const WorkerInfo info{name, process, 1, digest_of("build")};
    auto joined = scheduler_.worker_joined(info, now_);
    take(joined.actions);
    return joined.worker;
  };
  const WorkerId small = start("process 1", "small");
  ASSERT_EQ(held_[small].size(), 2U);
  leave(small, false);  // while it built the scene
  const WorkerId again = start("process 2", "small");
  EXPECT_EQ(held_[again].size(), 2U) << "there is nobody else";
  leave(again, true);
  const WorkerId large = start("process 3", "large");
  ready(large);
  EXPECT_EQ(held_[large].size(), 2U);
  const WorkerId third = start("process 4", "small");
  EXPECT_TRUE(held_[third].empty());
  leave(large, true);
  EXPECT_EQ(held_[third].size(), 2U) << "the last that can has gone";
}

TEST_F(QuarantineTest, AWorkerThatOnlyLostItsConnectionIsGivenTheSceneAgain) {
  add(1, spec(40, 1));
  const WorkerId a = join("a");
  leave(a, false);
  ready(join("b"));
  EXPECT_EQ(held_[join("a")].size(), 2U);
}

TEST_F(QuarantineTest, ThreeDeathsInPreparationWithNoneThatSurvivesItFailTheJob) {
  add(1, spec(40, 1));
  for (const char* name : {"a", "b"}) leave(join(name), false);
  EXPECT_TRUE(failed_.empty());
  leave(join("c"), false);
  EXPECT_THAT(failed_[1], HasSubstr("3 workers"));
}

TEST_F(QuarantineTest, ASurvivorOfPreparationEndsTheRow) {
  add(1, spec(40, 1));
  for (const char* name : {"a", "b"}) leave(join(name), false);
  ready(join("good"));
  for (const char* name : {"c", "d"}) leave(join(name), false);
  EXPECT_TRUE(failed_.empty());
}

TEST_F(QuarantineTest, APersonQuarantinesAndReleases) {
  add(1, spec(4, 1));
  const WorkerId a = join("a");
  ready(a);
  take(scheduler_.quarantine("a", "its fan is broken", now_));
  EXPECT_TRUE(held_[a].empty());
  EXPECT_EQ(view(a).state, "quarantined");
  EXPECT_EQ(view(a).reason, "its fan is broken");
  EXPECT_EQ(quarantined_[a], "its fan is broken") << "it is to be told";
  const WorkerId b = join("b");
  ready(b);
  EXPECT_EQ(held_[b].size(), 2U) << "what it held is out again, and no suspect";
  take(scheduler_.release("a", now_));
  EXPECT_EQ(held_[a].size(), 2U);
}

TEST_F(QuarantineTest, APreparationThatDoesNotGetOnFailsThoughItsWorkerSaysThatItGoesOn) {
  add(1, spec(4, 1));
  const WorkerId hung = join("hung");
  const double limit = seconds(settings_.preparation);
  const auto says_preparing = [&](double until, double fraction) {
    for (double waited = 0; waited < until; waited += 2) {
      take(scheduler_.worker_preparing(hung, 1, fraction, now_));
      pass(2);
    }
  };
  says_preparing(limit - 4, 0.1);
  says_preparing(limit - 4, 0.2);
  EXPECT_EQ(held_[hung].size(), 2U) << "it got on in between";
  const WorkerId other = join("other");
  ASSERT_EQ(held_[other].size(), 2U);
  leave(other, true);
  EXPECT_TRUE(revoked_.empty());
  says_preparing(8, 0.2);
  EXPECT_EQ(revoked_.size(), 2U);
  EXPECT_TRUE(failed_.empty());
  EXPECT_EQ(view(hung).state, "stalled");
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(held_[hung].empty()) << "it is still at it";
    EXPECT_TRUE(failed_.empty());
    says_preparing(limit + 8, 0.2);
  }
  EXPECT_THAT(failed_[1], HasSubstr("did not get on for 1800 s"));
}

TEST_F(QuarantineTest, AWorkerWhosePreparerHangsIsGivenNoOtherJobUntilItStopsSayingSo) {
  add(1, spec(4, 1));
  const WorkerId hung = join("hung");
  const auto beats = [&](double until, bool at_it) {
    for (double waited = 0; waited < until; waited += 2) {
      take(scheduler_.worker_progress(hung, {}, now_));
      if (at_it) take(scheduler_.worker_preparing(hung, 1, 0.2, now_));
      pass(2);
    }
  };
  beats(seconds(settings_.preparation) + 8, true);
  ASSERT_EQ(failures_.size(), 1U);
  take(scheduler_.cancel_job(1, now_));
  add(2, spec(4, 1));
  beats(seconds(settings_.preparation) + 8, true);
  EXPECT_TRUE(held_[hung].empty());
  EXPECT_EQ(view(hung).state, "stalled");
  EXPECT_EQ(failures_.size(), 1U) << "nothing of job 2 is held against anybody";
  beats(4, false);
  EXPECT_EQ(held_[hung].size(), 2U);
}

TEST_F(QuarantineTest, WhatAHungWorkerWasGivenBeforeItSaidSoIsHeldAgainstNobody) {
  add(1, spec(4, 1));
  const WorkerId hung = join("hung");
  take(scheduler_.worker_preparing(hung, 1, 0.2, now_));
  take(scheduler_.cancel_job(1, now_));
  add(2, spec(4, 1));
  ASSERT_EQ(held_[hung].size(), 2U);
  for (double waited = 0; waited < seconds(settings_.preparation) + 8; waited += 2) {
    take(scheduler_.worker_progress(hung, {}, now_));
    take(scheduler_.worker_preparing(hung, 1, 0.2, now_));
    take(scheduler_.worker_preparing(hung, 2, 0, now_));
    pass(2);
  }
  EXPECT_TRUE(held_[hung].empty());
  EXPECT_TRUE(failures_.empty());
  EXPECT_TRUE(failed_.empty());
  EXPECT_EQ(held_[join("other")].size(), 2U);
}

TEST_F(QuarantineTest, ASceneThatIsBuiltAgainIsPreparedAgain) {
  add(1, spec(200, 1));
  const WorkerId a = join("a");
  const auto says_preparing = [&](double until, double fraction) {
    for (double waited = 0; waited < until; waited += 2) {
      take(scheduler_.worker_preparing(a, 1, fraction, now_));
      pass(2);
    }
  };
  const auto speed = [&] { return scheduler_.workers(now_).at(0).samples_per_second; };
  const double most = seconds(settings_.preparation) - 4;
  says_preparing(4, 0.9);
  ready(a);
  for (int i = 0; i < 4; ++i) {
    pass(1);
    finish_one(a);
  }
  const double before = speed();
  EXPECT_EQ(view(a).state, "rendering");
  // It dropped the scene. What has been built of it falls behind what had been, and grows.
  says_preparing(most, 0);
  EXPECT_EQ(view(a).state, "preparing");
  for (const double fraction : {0.3, 0.6, 0.2, 0.5}) says_preparing(most, fraction);
  EXPECT_TRUE(failures_.empty());
  EXPECT_TRUE(revoked_.empty());
  ready(a);
  EXPECT_EQ(view(a).state, "rendering");
  pass(1);
  finish_one(a);
  EXPECT_NEAR(speed(), before, 0.01 * before) << "no time of preparation is time of rendering";
}

TEST_F(QuarantineTest, AHungPreparationIsForAnotherWorker) {
  add(1, spec(2, 1));
  const WorkerId hung = join("hung");
  const WorkerId other = join("other");
  EXPECT_TRUE(held_[other].empty());
  for (double waited = 0; waited < seconds(settings_.preparation) + 4; waited += 2) {
    take(scheduler_.worker_preparing(hung, 1, 0, now_));
    scheduler_.worker_heard(other, now_);
    pass(2);
  }
  EXPECT_TRUE(held_[hung].empty());
  EXPECT_EQ(held_[other].size(), 2U);
  ASSERT_EQ(failures_.size(), 1U);
  EXPECT_EQ(failures_[0].outcome, AttemptFailed::Outcome::stalled);
}

TEST_F(QuarantineTest, AQuarantinedWorkerIsToldOnceEachTimeThatItComes) {
  const WorkerId a = join("a");
  take(scheduler_.quarantine("a", "its fan is broken", now_));
  quarantined_.clear();
  pass(1);
  EXPECT_TRUE(quarantined_.empty());
  leave(a, true);
  EXPECT_EQ(join("a"), a);
  EXPECT_EQ(quarantined_[a], "its fan is broken");
}

TEST_F(QuarantineTest, AQuarantineIsOfANameAndHoldsForEveryProcessOfIt) {
  add(1, spec(40, 1));
  const auto start = [&](const std::string& process) {
    auto joined = scheduler_.worker_joined({"machine", process, 1, digest_of("build")}, now_);
    take(joined.actions);
    return joined.worker;
  };
  take(scheduler_.quarantine("machine", "its disk is full", now_));  // as after a start
  const WorkerId first = start("process 1");
  EXPECT_EQ(view(first).state, "quarantined");
  EXPECT_EQ(view(first).reason, "its disk is full");
  leave(first, false);
  const WorkerId second = start("process 2");
  EXPECT_TRUE(held_[second].empty());
  EXPECT_EQ(quarantined_[second], "its disk is full");
  EXPECT_EQ(held_[join("other")].size(), 2U);
  take(scheduler_.release("machine", now_));
  EXPECT_EQ(held_[second].size(), 2U);
  const WorkerId third = start("process 3");
  EXPECT_EQ(held_[third].size(), 2U);
  take(scheduler_.quarantine("machine", "", now_));
  EXPECT_TRUE(held_[second].empty() && held_[third].empty()) << "what they hold is revoked";
  EXPECT_EQ(view(third).state, "quarantined");
}

TEST_F(QuarantineTest, AMachineThatFailsIsBarredForItsNextProcessToo) {
  two_jobs();
  fail_one(bad_);
  fail_until_job_2(bad_);
  fail_one(bad_);
  ASSERT_EQ(view(bad_).state, "quarantined");
  leave(bad_, false);
  auto joined = scheduler_.worker_joined({"bad", "a new process", 1, digest_of("build")}, now_);
  take(joined.actions);
  EXPECT_EQ(view(joined.worker).state, "quarantined");
  EXPECT_TRUE(held_[joined.worker].empty());
}

}  // namespace
}  // namespace tessera::server
