// Scenes that workers could not prepare: what is held against the job, and what against nobody.
#include <gmock/gmock.h>

#include "tests/unit/schedule/schedule_fixture.hpp"

namespace tessera::server {
namespace {

using ::testing::HasSubstr;

class PreparationTest : public ScheduleTest {
 protected:
  WorkerId start(const std::string& process, const std::string& name) {
    auto joined = scheduler_.worker_joined({name, process, 1, digest_of("build")}, now_);
    take(joined.actions);
    return joined.worker;
  }
  /// What the worker holds first is of a job whose scene it cannot get.
  JobId cannot_prepare(WorkerId worker) {
    const JobId job = held_[worker].at(0).job;
    std::erase_if(held_[worker], [&](const GrantLease& grant) { return grant.job == job; });
    take(scheduler_.worker_failed(worker, job, std::nullopt, "its disk is full", now_));
    return job;
  }
  /// What the worker holds first is of a job that names files that it cannot read.
  void lacks_files(WorkerId worker) {
    const JobId job = held_[worker].at(0).job;
    std::erase_if(held_[worker], [&](const GrantLease& grant) { return grant.job == job; });
    take(scheduler_.worker_lacks_files(worker, job, "no disk", now_));
  }
  /// Everyone is heard; errors' rests go by.
  void rest(double seconds = 2) {
    for (double waited = 0; waited < seconds; waited += 0.5) {
      for (const WorkerView& one : scheduler_.workers(now_)) scheduler_.worker_heard(one.id, now_);
      pass(0.5);
    }
  }
};

TEST_F(PreparationTest, AMachineThatIsStartedAgainAndAgainDoesNotFailAJobThatOthersPrepare) {
  add(1, spec(200, 1));
  const WorkerId good = join("good");
  for (const char* process : {"1", "2", "3", "4", "5"}) {
    const WorkerId worker = start(process, "small");
    cannot_prepare(worker);
    leave(worker, false);
    rest();
  }
  EXPECT_TRUE(failed_.empty());
  ready(good);
  finish_one(good);
  EXPECT_FALSE(held_[good].empty());
}

TEST_F(PreparationTest, AMachineThatIsAloneAndCannotPrepareAJobFailsItThoughItIsStartedAgain) {
  add(1, spec(200, 1));
  for (const char* process : {"1", "2", "3"}) {
    EXPECT_TRUE(failed_.empty());
    const WorkerId worker = start(process, "small");
    cannot_prepare(worker);
    leave(worker, false);
  }
  EXPECT_THAT(failed_[1], HasSubstr("its disk is full"));
}

TEST_F(PreparationTest, AJobThatWasRenderedWaitsForAWorkerThatCanPrepareIt) {
  add(1, spec(200, 1));
  const WorkerId good = join("good");
  ready(good);
  finish_one(good);
  leave(good, true);
  for (int i = 0; i < 3; ++i) {
    for (const char* name : {"a", "b", "c", "d"}) {
      const WorkerId worker = join(name);
      if (!held_[worker].empty()) cannot_prepare(worker);
    }
    EXPECT_THAT(scheduler_.job(1, now_)->waiting_for, HasSubstr("its disk is full"));
    rest(8);
    for (const WorkerView& view : scheduler_.workers(now_))
      if (!held_[view.id].empty()) cannot_prepare(view.id);
  }
  EXPECT_TRUE(failed_.empty());
  EXPECT_FALSE(held_[join("another")].empty());
}

TEST_F(PreparationTest, AFewThatFailAtOnceDoNotFailAJobThatMoreStillPrepare) {
  add(1, spec(200, 1));
  std::vector<WorkerId> slow;
  for (const char* name : {"p", "q", "r", "s", "t"}) slow.push_back(join(name));
  for (const char* name : {"a", "b", "c"}) cannot_prepare(join(name));
  EXPECT_TRUE(failed_.empty());
  cannot_prepare(slow[0]);
  EXPECT_THAT(failed_[1], HasSubstr("its disk is full")) << "four could not, four still prepare it";
}

TEST_F(PreparationTest, AWorkerThatGetsReadyEndsTheCountOfThoseThatCouldNot) {
  add(1, spec(200, 1));
  const WorkerId good = join("good");
  for (const char* name : {"a", "b"}) cannot_prepare(join(name));
  ready(good);
  leave(good, true);
  cannot_prepare(join("c"));
  EXPECT_TRUE(failed_.empty());
}

TEST_F(PreparationTest, AnOutageThatManyShareQuarantinesNobody) {
  add(1, spec(400, 1));
  const WorkerId good = join("good");
  ready(good);
  finish_one(good);
  add(2, spec(400, 1));
  while (held_[good].at(0).job == 1) {
    rest();
    finish_one(good);
  }
  ready(good, 2);
  finish_one(good);
  std::map<WorkerId, std::set<JobId>> could_not;
  for (const char* name : {"a", "b", "c", "d", "e"}) could_not[join(name)];
  for (int i = 0; i < 4; ++i) {
    for (auto& [worker, jobs] : could_not)
      if (!held_[worker].empty()) jobs.insert(cannot_prepare(worker));
    rest(4);
  }
  for (const auto& [worker, jobs] : could_not) EXPECT_EQ(jobs, (std::set<JobId>{1, 2}));
  EXPECT_TRUE(quarantined_.empty());
  EXPECT_TRUE(failed_.empty());
  add(3, spec(400, 1));
  for (const auto& [worker, jobs] : could_not) EXPECT_EQ(held_[worker].at(0).job, 3U);
}

TEST_F(ScheduleTest, OfProcessesThatHaveGoneTheLast16384AreKnown) {
  const auto come_and_go = [&](int count, const std::string& prefix) {
    for (int i = 0; i < count; ++i) leave(join(prefix + std::to_string(i)), true);
  };
  const WorkerId first = join("first"), second = join("second"), third = join("third");
  leave(second, true);
  leave(third, true);
  EXPECT_EQ(join("third"), third);
  come_and_go(16383, "a");
  leave(first, true);
  EXPECT_NE(join("second"), second) << "16,385 have gone since";
  come_and_go(16383, "b");
  EXPECT_EQ(join("first"), first) << "among the last 16,384";
  leave(third, true);
  EXPECT_EQ(join("third"), third) << "it was here, and is not forgotten for having been away once";
}

TEST_F(PreparationTest, WorkersWithoutTheFilesThatAJobNamesAreHeldAgainstNobody) {
  add(1, spec(200, 1));
  for (const char* name : {"a", "b", "c", "d"}) lacks_files(join(name));
  EXPECT_TRUE(failed_.empty());
  EXPECT_THAT(scheduler_.job(1, now_)->waiting_for,
              HasSubstr("no connected worker can read its files: no disk"));
  const WorkerId good = join("good");
  EXPECT_FALSE(held_[good].empty());
  EXPECT_EQ(scheduler_.job(1, now_)->waiting_for, "");
  rest(10);
  for (const auto& [worker, held] : held_) EXPECT_EQ(held.empty(), worker != good) << worker;
  ready(good);
  finish_one(good);
  EXPECT_TRUE(failed_.empty());
}

TEST_F(PreparationTest, AWorkerWithoutAJobsFilesDoesOthersAndHasThemWhenItIsStartedAgain) {
  add(1, spec(200, 1));
  const WorkerId worker = start("first", "small");
  lacks_files(worker);
  EXPECT_TRUE(held_[worker].empty());
  add(2, spec(200, 1));
  ASSERT_FALSE(held_[worker].empty());
  EXPECT_EQ(held_[worker].at(0).job, 2U);
  leave(worker, true);
  const WorkerId again = start("second", "small");
  EXPECT_FALSE(held_[again].empty());
  EXPECT_TRUE(failed_.empty());
}

}  // namespace
}  // namespace tessera::server
