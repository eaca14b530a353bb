// Frames of a job end by their noise one by one, each as if it were a job of its own.
#include <limits>

#include "tests/unit/schedule/schedule_fixture.hpp"

namespace tessera::server {
namespace {

class NoiseFramesTest : public ScheduleTest {
 protected:
  /// 4 tiles; ends 1, 4, 16, 64, 256, 512, …
  static JobSpec watched(int frames) {
    JobSpec job = spec(4, 4096, {1, frames, 1});
    job.noise_threshold = 0.01;
    return job;
  }
  /// Everything that is handed out comes in.
  void render_what_there_is(WorkerId worker) {
    while (!held_[worker].empty()) {
      pass(0.01);
      const GrantLease done = finish_one(worker);
      std::uint32_t& passes = passes_[{done.task.frame, done.task.tile}];
      passes = std::max(passes, done.task.pass + 1);
    }
  }
  /// The looks that are asked for are answered as `ends` says: samples with which a frame's noise
  /// is low enough.
  void answer(const std::map<std::int32_t, std::int64_t>& ends) {
    for (const MeasureNoise& asked : std::exchange(asked_, {})) {
      const std::int64_t samples = plans_[asked.job]->passes.pass(asked.passes - 1).end();
      const auto end = ends.find(asked.frame);
      const bool low = end != ends.end() && samples >= end->second;
      take(
          scheduler_.noise_measured(asked.job, asked.frame, asked.passes, low ? 0.01 : 0.02, now_));
    }
  }
  void expect_passes(std::int32_t frame, std::uint32_t passes) {
    for (std::uint32_t tile = 0; tile < 4; ++tile)
      EXPECT_EQ((passes_[{frame, tile}]), passes) << frame << ' ' << tile;
  }
  std::map<std::pair<std::int32_t, std::uint32_t>, std::uint32_t> passes_;  // of each tile
};

TEST_F(NoiseFramesTest, EachEndsAtItsOwnLookAndTheJobWithTheLast) {
  add(1, watched(3));
  const WorkerId a = join("a");
  ready(a);
  for (int turn = 0; finished_.empty() && turn < 100; ++turn) {
    render_what_there_is(a);
    answer({{1, 64}, {2, 16}});
  }
  ASSERT_EQ(finished_, std::vector<JobId>{1});
  const std::map<std::pair<JobId, std::int32_t>, std::int64_t> ends{{{1, 1}, 64}, {{1, 2}, 16}};
  EXPECT_EQ(frames_shortened_, ends);
  EXPECT_TRUE(shortened_.empty()) << "the job itself keeps its samples";
  EXPECT_EQ(frames_, (std::vector<std::int32_t>{2, 1, 3})) << "the easy one first";
  expect_passes(1, 4);
  expect_passes(2, 3);
  expect_passes(3, plans_[1]->passes.count());
  const JobView view = *scheduler_.job(1, now_);
  EXPECT_EQ(view.samples, 4 * 256 * (64 + 16 + 4096));
  EXPECT_EQ(view.samples_done, view.samples);
  EXPECT_EQ(view.tasks, 4 * (4 + 3 + static_cast<std::int64_t>(plans_[1]->passes.count())));
  EXPECT_EQ(view.tasks_done, view.tasks);
}

TEST_F(NoiseFramesTest, OthersGoOnWhileOneWaitsForItsLook) {
  add(1, watched(2));
  const WorkerId a = join("a");
  ready(a);
  render_what_there_is(a);
  expect_passes(1, 3);
  expect_passes(2, 3);
  ASSERT_EQ(asked_.size(), 2U);
  EXPECT_EQ(asked_[0].frame, 1);
  EXPECT_EQ(asked_[1].frame, 2);
  take(scheduler_.noise_measured(1, 2, 3, 0.02, now_));
  render_what_there_is(a);
  expect_passes(1, 3);
  expect_passes(2, 4);
  take(scheduler_.noise_measured(1, 7, 3, 0, now_));
  take(scheduler_.noise_measured(1, 2, 3, 0, now_));
  EXPECT_TRUE(frames_shortened_.empty()) << "a frame that is none, and a look that is long over";
  take(scheduler_.noise_measured(1, 1, 3, 0.01, now_));
  EXPECT_EQ(frames_, std::vector<std::int32_t>{1});
  take(scheduler_.noise_measured(1, 1, 3, 0.01, now_));
  EXPECT_EQ(frames_.size(), 1U) << "said twice";
}

TEST_F(NoiseFramesTest, APausedJobTakesItsAnswersAndGoesOnWhenItIsResumed) {
  add(1, watched(2));
  const WorkerId a = join("a");
  ready(a);
  render_what_there_is(a);
  take(scheduler_.pause_job(1, now_));
  take(scheduler_.noise_measured(1, 1, 3, 0.01, now_));
  take(scheduler_.noise_measured(1, 2, 3, 0.02, now_));
  EXPECT_EQ(frames_, std::vector<std::int32_t>{1});
  pass(1);
  EXPECT_TRUE(held_[a].empty());
  take(scheduler_.resume_job(1, now_));
  ASSERT_FALSE(held_[a].empty());
  EXPECT_EQ(held_[a][0].task, (TaskId{2, held_[a][0].task.tile, 3}));
}

TEST_F(NoiseFramesTest, AFocusGoesFirstUpToTheLookAndChangesNoEnd) {
  JobSpec job = watched(2);
  job.focus = Rect{32, 0, 16, 16};
  add(1, job);
  const WorkerId a = join("a");
  ready(a);
  std::vector<TaskId> order;
  while (!held_[a].empty()) {
    pass(0.01);
    order.push_back(finish_one(a).task);
  }
  EXPECT_EQ(order.size(), 2U * 4 * 3);
  EXPECT_EQ(order[0], (TaskId{1, 2, 0}));
  ASSERT_EQ(asked_.size(), 2U);
  answer({{1, 16}, {2, 64}});
  EXPECT_EQ(frames_, std::vector<std::int32_t>{1});
  ASSERT_FALSE(held_[a].empty());
  EXPECT_EQ(held_[a][0].task, (TaskId{2, 2, 3}));
  take(scheduler_.set_focus(1, std::nullopt, now_));
  render_what_there_is(a);
  answer({{2, 64}});
  EXPECT_EQ(finished_, std::vector<JobId>{1});
  EXPECT_EQ((frames_shortened_[{1, 2}]), 64);
}

TEST_F(NoiseFramesTest, AStartKnowsWhichHaveEndedAndAsksForTheOthers) {
  plans_[1] = std::make_shared<const JobPlan>(watched(3));
  take(scheduler_.add_job(1, plans_[1], now_));
  EXPECT_TRUE(scheduler_.restore_shortened(1, 1, 16));
  const std::uint32_t begun = 3;  // passes of frame 3, but for one tile that has another
  for (const std::int32_t frame : {1, 2, 3})
    for (std::uint32_t tile = 0; tile < 4; ++tile)
      for (std::uint32_t pass = 0; pass < begun + (frame == 3 && tile == 0 ? 1 : 0); ++pass)
        scheduler_.restore_closed(1, {frame, tile, pass});
  for (const std::int32_t frame : {1, 2, 3})
    for (std::uint32_t tile = 0; tile < 4; ++tile)
      take(scheduler_.tile_folded(1, frame, tile, begun + (frame == 3 && tile == 0 ? 1 : 0), now_));
  EXPECT_EQ(frames_, std::vector<std::int32_t>{1});
  EXPECT_EQ((frames_shortened_[{1, 1}]), 16);
  ASSERT_EQ(asked_.size(), 1U) << "of the third a later pass was begun: its look is over";
  EXPECT_EQ(asked_[0].frame, 2);
  EXPECT_EQ(asked_[0].passes, 3U);
  const WorkerId a = join("a");
  ready(a);
  ASSERT_FALSE(held_[a].empty());
  for (const GrantLease& grant : held_[a]) EXPECT_EQ(grant.task.frame, 3);
  const JobView view = *scheduler_.job(1, now_);
  EXPECT_EQ(view.samples, 4 * 256 * (16 + 2 * 4096));
  EXPECT_EQ(view.samples_done, 256 * (3 * 4 * 16 + 48));
}

TEST_F(NoiseFramesTest, WhatIsNoEndOfAPassIsNotTakenAfterAStart) {
  plans_[1] = std::make_shared<const JobPlan>(watched(2));
  take(scheduler_.add_job(1, plans_[1], now_));
  for (const std::int64_t samples : {-1, 0, 17, 4096, 5000})
    EXPECT_FALSE(scheduler_.restore_shortened(1, 1, samples));
  EXPECT_FALSE(scheduler_.restore_shortened(1, 3, 16));
  EXPECT_FALSE(scheduler_.restore_shortened(2, 1, 16));
  EXPECT_EQ(scheduler_.job(1, now_)->samples, 4 * 256 * 2 * 4096);
  EXPECT_TRUE(scheduler_.restore_shortened(1, 2, 64));
  EXPECT_FALSE(scheduler_.restore_shortened(1, 2, 64));
  EXPECT_EQ(scheduler_.job(1, now_)->samples, 4 * 256 * (64 + 4096));
}

TEST_F(NoiseFramesTest, LateResultsOfPassesThatWereCutAreStaleAndNobodysFault) {
  JobSpec all = watched(2);
  all.noise_threshold = 0;
  add(1, all);
  const WorkerId a = join("a");
  ready(a);
  while (held_[a].at(0).task.pass < 3) finish_one(a);
  const GrantLease late = held_[a].at(0);
  ASSERT_EQ(late.task.frame, 1);
  const JobPlan before = *plans_[1];
  plans_[1] = std::make_shared<const JobPlan>(watched(2));
  ASSERT_EQ(plans_[1]->digest, before.digest);
  take(scheduler_.replace_job(1, plans_[1], now_, {}));
  EXPECT_TRUE(scheduler_.restore_shortened(1, 1, 16));
  EXPECT_EQ(arrive(a, late), Verdict::stale);
  pass(0);
  EXPECT_TRUE(dropped_.empty());
}

TEST_F(NoiseFramesTest, FramesToComeAreExpectedToNeedWhatThoseNeededThatHaveEnded) {
  const auto left = [&] { return scheduler_.job(1, now_)->eta_seconds.value_or(-1); };
  add(1, watched(50));
  const WorkerId a = join("a");
  ready(a);
  for (int i = 0; i < 40; ++i) {
    pass(0.01);
    finish_one(a);
  }
  const double before = left();
  ASSERT_GT(before, 0);
  answer({{1, 16}, {2, 16}, {3, 16}});
  ASSERT_EQ(frames_, (std::vector<std::int32_t>{1, 2, 3}));
  EXPECT_LT(left(), before / 50) << "16 samples each, not 4096";
  EXPECT_GT(left(), 0);
}

TEST_F(NoiseFramesTest, AFrameIsExpectedToNeedTheSamplesThatItsNoiseSays) {
  JobId job = 0;
  const auto left_at = [&](double noise, int frames) {
    add(++job, watched(frames));
    const WorkerId a = join("a" + std::to_string(job));
    take(scheduler_.worker_ready(a, job, now_));
    for (int i = 0; i < 12 * frames; ++i) {
      pass(0.01);
      finish_one(a);
    }
    for (int frame = 1; frame < frames; ++frame)
      take(scheduler_.noise_measured(job, frame, 3, 0.01, now_));
    take(scheduler_.noise_measured(job, frames, 3, noise, now_));
    const double left = scheduler_.job(job, now_)->eta_seconds.value_or(-1);
    take(scheduler_.cancel_job(job, now_));
    take(scheduler_.worker_left(a, true, now_));
    return left;
  };
  for (const int frames : {1, 3}) {
    SCOPED_TRACE(frames);
    // The last frame is to have 64 samples, 1024, and all, of which it has 16.
    const double easy = left_at(0.02, frames), hard = left_at(0.08, frames),
                 endless = left_at(std::numeric_limits<double>::infinity(), frames);
    EXPECT_GT(easy, 0);
    EXPECT_GT(hard, 10 * easy);
    EXPECT_LT(hard, 25 * easy);
    EXPECT_NEAR(endless / hard, (4096 - 16) / (1024 - 16.0), 0.5);
  }
}

TEST_F(NoiseFramesTest, OtherJobsDoNotExpectToShareWithWhatIsSpared) {
  add(1, watched(50));
  add(2, spec(4, 4096, {1, 10, 1}));
  const WorkerId a = join("a");
  const WorkerId b = join("b");
  for (const WorkerId worker : {a, b})
    for (const JobId job : {1, 2}) ready(worker, job);
  for (int i = 0; i < 120; ++i) {
    pass(0.01);
    for (const WorkerId worker : {a, b})
      if (!held_[worker].empty()) finish_one(worker);
  }
  pass(0.01);
  const auto left = [&] { return scheduler_.job(2, now_)->eta_seconds.value_or(-1); };
  const double before = left();
  ASSERT_GT(before, 0);
  ASSERT_FALSE(asked_.empty());
  for (const MeasureNoise& asked : std::exchange(asked_, {}))
    take(scheduler_.noise_measured(1, asked.frame, asked.passes, 0.01, now_));
  pass(0.001);
  EXPECT_LT(left(), 0.7 * before) << "the other has a fifth of its work, not five times";
  EXPECT_GT(left(), 0.3 * before);
}

}  // namespace
}  // namespace tessera::server
