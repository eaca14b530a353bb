// What is left, how fast it goes, and when it is done.
#include "server/schedule/finish.hpp"

#include "server/schedule/work_left.hpp"
#include "tests/unit/schedule/schedule_fixture.hpp"

namespace tessera::server {
namespace {

Pace some_pace() {
  Pace pace;
  pace.work = 1000;
  pace.power = 10;
  pace.workers = 10;
  pace.task_seconds = 1;
  pace.elapsed = 100;
  return pace;
}

TEST(TimeToFinish, IsWhatIsLeftAtThePresentPowerAndTheTail) {
  const TimeToFinish time = time_to_finish(some_pace());
  EXPECT_NEAR(time.expected, 100, 1);
  EXPECT_GT(time.expected, 100) << "workers run dry before the end";
  EXPECT_LT(time.low, time.expected);
  EXPECT_GT(time.high, time.expected);
}

TEST(TimeToFinish, WidensWithWorkersThatCameAndWent) {
  Pace restless = some_pace();
  restless.changes = 0.05;
  const TimeToFinish calm = time_to_finish(some_pace()), other = time_to_finish(restless);
  EXPECT_GT(other.high - other.low, 2 * (calm.high - calm.low));
}

TEST(TimeToFinish, HasItsPartOfTheWorkersUntilOthersAreDoneAndThenAll) {
  Pace pace = some_pace();  // 100 s alone
  pace.rivals = {{.seconds = 50, .weight = 1}, {.seconds = 1e6, .weight = 2}};
  pace.weight = 1;
  // Half the farm is the long one's; of the rest each has half until the short one is done.
  const double until = 50 * 4;
  EXPECT_NEAR(time_to_finish(pace).expected, until + 50 * 3, 5);
  pace.rivals = {{.seconds = 0, .weight = 5}};
  EXPECT_NEAR(time_to_finish(pace).expected, time_to_finish(some_pace()).expected, 1e-6);
}

TEST(TimeToFinish, WidensWithOthersOfWhomLessIsKnown) {
  Pace pace = some_pace();
  pace.rivals = {{.seconds = 100, .weight = 1}};
  const TimeToFinish alone = time_to_finish(some_pace()), among = time_to_finish(pace);
  EXPECT_GT((among.high - among.low) / among.expected,
            1.5 * (alone.high - alone.low) / alone.expected);
}

TEST(TimeToFinish, IsNeverNegative) {
  for (const double work : {0.0, 1e-9, 1.0, 1e9})
    for (const double task : {0.0, 1.0, 1e4})
      for (const double changes : {0.0, 1.0, 1e3}) {
        Pace pace = some_pace();
        pace.work = work;
        pace.task_seconds = task;
        pace.changes = changes;
        for (const double rival : {-1.0, 0.0, 1.0, 1e9}) {
          pace.rivals.clear();
          if (rival >= 0) pace.rivals.push_back({rival, 3});
          const TimeToFinish time = time_to_finish(pace);
          EXPECT_GE(time.low, 0);
          EXPECT_LE(time.low, time.expected);
          EXPECT_LE(time.expected, time.high);
        }
      }
}

TEST(WorkLeft, KnowsTilesByWhatTheyCost) {
  JobSpec spec;
  spec.render.width = 64;
  spec.render.height = 16;
  spec.render.samples = 16;  // ends 1, 4, 16
  spec.tile = 16;
  WorkLeft left{JobPlan(spec)};
  EXPECT_DOUBLE_EQ(left.work(), 4 * 256 * 16);
  left.measured(0, 256, 3 * 256);
  EXPECT_DOUBLE_EQ(left.cost(0), 3);
  EXPECT_DOUBLE_EQ(left.cost(1), 3) << "all that is known";
  left.closed(0, 256);
  left.measured(1, 256, 256);
  left.closed(1, 256);
  EXPECT_DOUBLE_EQ(left.cost(2), 2);
  EXPECT_DOUBLE_EQ(left.work(), 256.0 * (15 * 3 + 15 * 1 + 2 * 16 * 2));
  EXPECT_DOUBLE_EQ(left.work_of(12), 256.0 * 12 * (3 + 1 + 2 + 2));
  EXPECT_GT(left.spread(), 0);
  left.cut(12);
  EXPECT_DOUBLE_EQ(left.work(), 256.0 * (3 * 3 + 3 * 1 + 2 * 4 * 2));
}

TEST_F(ScheduleTest, TheTimeToFinishKnowsTilesThatCostMore) {
  JobSpec job = spec(10, 64);  // ends 1, 4, 16, 64
  job.order = TileOrder::scanline;
  add(1, job);
  const WorkerId worker = join("a");
  ready(worker);
  // The last tile costs nine times as much as the others. Until it comes in the last pass:
  const auto seconds_of = [&](const TaskId& task) {
    return 0.01 * static_cast<double>(plans_[1]->passes.pass(task.pass).count) *
           (task.tile == 9 ? 9 : 1);
  };
  while (held_[worker].at(0).task != TaskId{1, 9, 3}) {
    pass(seconds_of(held_[worker].at(0).task));
    finish_one(worker);
  }
  const JobView view = *scheduler_.job(1, now_);
  EXPECT_NEAR(*view.eta_low_seconds, 4.3, 1.5);
  EXPECT_GT(*view.eta_high_seconds, 4.3) << "and not a tenth of a tenth of the work";
}

}  // namespace
}  // namespace tessera::server
