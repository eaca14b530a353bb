// What jobs are owed by jobs that could not be worked at.
#include "tests/unit/schedule/schedule_fixture.hpp"

namespace tessera::server {
namespace {

class SharesTest : public ScheduleTest {
 protected:
  /// Each worker renders a task every half second; how many of each job.
  std::map<JobId, int> render(double seconds) {
    std::map<JobId, int> done;
    for (double past = 0; past < seconds; past += 0.5) {
      for (const auto& [worker, grants] : std::map(held_))
        if (!grants.empty()) ready(worker, grants[0].job);
      pass(0.5);
      for (const WorkerView& worker : scheduler_.workers(now_)) {
        scheduler_.worker_heard(worker.id, now_);
        if (held_[worker.id].empty()) continue;
        ++done[finish_one(worker.id).job];
      }
    }
    return done;
  }
  static double part(std::map<JobId, int>& done, JobId of, JobId beside) {
    return done[of] / static_cast<double>(std::max(1, done[of] + done[beside]));
  }
};

TEST_F(SharesTest, ANewJobIsNotOwedWhatAJobAtItsMostOfWorkersCouldNotTake) {
  JobSpec single = spec(9000, 1);
  single.max_workers = 1;
  add(1, single);
  add(2, spec(9000, 1));
  for (const char* name : {"a", "b", "c", "d"}) join(name);
  render(300);
  add(3, spec(9000, 1));
  std::map<JobId, int> done = render(100);
  EXPECT_NEAR(part(done, 2, 3), 0.5, 0.15);
}

TEST_F(SharesTest, AJobThatHadNoWorkerIsNotOwedThatTime) {
  JobSpec mixed = spec(9000, 1);
  mixed.mixed = true;
  add(1, spec(9000, 1));
  const WorkerId a = join("a", "one");
  render(10);  // from here on job 1 is of build one
  add(2, mixed);
  leave(a, true);
  const WorkerId b = join("b", "two");
  render(300);
  leave(b, true);
  join("c", "one");
  std::map<JobId, int> done = render(100);
  EXPECT_NEAR(part(done, 2, 1), 0.5, 0.15);
}

}  // namespace
}  // namespace tessera::server
