// A focus region: what a person wants to see is rendered first.
#include "tests/unit/schedule/schedule_fixture.hpp"

namespace tessera::server {
namespace {

class FocusTest : public ScheduleTest {
 protected:
  /// 6 by 1 tiles in scanline order.
  static JobSpec scanline(std::int64_t samples) {
    JobSpec job = spec(6, samples);
    job.order = TileOrder::scanline;
    return job;
  }
  /// Renders `count` tasks one after another; which they were.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> render(WorkerId worker, int count) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> tasks;
    for (int i = 0; i < count && !held_[worker].empty(); ++i) {
      pass(0.6);
      scheduler_.worker_heard(worker, now_);
      const TaskId task = finish_one(worker).task;
      tasks.emplace_back(task.pass, task.tile);
    }
    return tasks;
  }
  using Tasks = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
};

TEST_F(FocusTest, ItsTilesComeFirstInTheFirstPassAndThenBeforeAllOthers) {
  JobSpec job = scanline(16);  // ends 1, 4, 16
  job.focus = Rect{32, 0, 17, 1};
  add(1, job);
  const WorkerId worker = join("a");
  ready(worker);
  EXPECT_EQ(render(worker, 18), (Tasks{{0, 2},
                                       {0, 3},
                                       {0, 0},
                                       {0, 1},
                                       {0, 4},
                                       {0, 5},  // the whole frame once
                                       {1, 2},
                                       {1, 3},
                                       {2, 2},
                                       {2, 3},  // all of the focus
                                       {1, 0},
                                       {1, 1},
                                       {1, 4},
                                       {1, 5},
                                       {2, 0},
                                       {2, 1},
                                       {2, 4},
                                       {2, 5}}));
  EXPECT_EQ(finished_, std::vector<JobId>{1});
}

TEST_F(FocusTest, ItIsMovedAndTakenAwayWhileTheJobRenders) {
  add(1, scanline(16));
  const WorkerId worker = join("a");
  ready(worker);
  render(worker, 6);
  take(scheduler_.set_focus(1, Rect{80, 0, 16, 16}, now_));
  // Two were in its hands already.
  EXPECT_EQ(render(worker, 4), (Tasks{{1, 0}, {1, 1}, {1, 5}, {2, 5}}));
  take(scheduler_.set_focus(1, Rect{64, 0, 1, 1}, now_));
  EXPECT_EQ(render(worker, 4), (Tasks{{1, 2}, {1, 3}, {1, 4}, {2, 4}}));
  take(scheduler_.set_focus(1, std::nullopt, now_));
  EXPECT_EQ(render(worker, 9), (Tasks{{2, 0}, {2, 1}, {2, 2}, {2, 3}}));
}

TEST_F(FocusTest, NoWorkerIdlesForIt) {
  JobSpec job = scanline(16);
  job.focus = Rect{0, 0, 1, 1};
  add(1, job);
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(held_[join(name)].size(), 2U);
}

TEST_F(FocusTest, InAFrameOfManyTilesItGoesBeforeWhatWasNotYetOffered) {
  JobSpec job = spec(1, 4);
  job.render.width = 3000;
  job.render.height = 1000;
  job.tile = 1;  // three million
  add(1, job);
  const WorkerId worker = join("a");
  ready(worker);
  render(worker, 2);
  take(scheduler_.set_focus(1, Rect{2999, 999, 1, 1}, now_));
  const auto tasks = render(worker, 3);
  EXPECT_EQ(tasks.back(), (std::pair<std::uint32_t, std::uint32_t>{0, 2'999'999}));
}

TEST_F(ScheduleTest, FewerWorkersMayBeAskedForWhileMoreAreAtIt) {
  add(1, spec(400, 1));
  std::vector<WorkerId> workers;
  for (const char* name : {"a", "b", "c", "d"}) workers.push_back(join(name));
  for (const WorkerId worker : workers) ready(worker);
  take(scheduler_.set_max_workers(1, 2, now_));
  const auto at_it = [&] {
    return std::count_if(workers.begin(), workers.end(),
                         [&](WorkerId worker) { return !held_[worker].empty(); });
  };
  EXPECT_EQ(at_it(), 4) << "what is out is finished";
  const auto go_on = [&] {
    pass(0.3);
    for (const WorkerId worker : workers) {
      scheduler_.worker_heard(worker, now_);
      if (!held_[worker].empty()) finish_one(worker);
    }
  };
  for (int i = 0; i < 3; ++i) go_on();
  for (int i = 0; i < 20; ++i) {
    go_on();
    EXPECT_EQ(at_it(), 2);
  }
  take(scheduler_.set_max_workers(1, 0, now_));
  EXPECT_EQ(at_it(), 4);
}

}  // namespace
}  // namespace tessera::server
