// A job that is to end by its noise does so at a whole pass, whatever the order of its results.
#include "server/schedule/noise_stop.hpp"

#include "tests/unit/schedule/schedule_fixture.hpp"

namespace tessera::server {
namespace {

TEST(NoiseLooks, AreAtSixteenSamplesAndThenWheneverThereAreAnEighthMore) {
  const PassPlan plan(100'000, 256);
  std::vector<std::int64_t> looks;
  for (std::uint32_t passes = 1; passes < plan.count(); ++passes)
    if (noise_is_looked_at(plan, passes)) looks.push_back(plan.pass(passes - 1).end());
  ASSERT_GE(looks.size(), 5U);
  EXPECT_EQ((std::vector(looks.begin(), looks.begin() + 4)),
            (std::vector<std::int64_t>{16, 64, 256, 512}));
  for (std::size_t i = 1; i < looks.size(); ++i) EXPECT_GE(8 * looks[i], 9 * looks[i - 1]);
  EXPECT_LE(looks.back() * 8, std::int64_t{100'000} * 9);
  EXPECT_EQ(next_look(plan, 0), 3U);
  EXPECT_EQ(next_look(plan, 4), 4U);
  EXPECT_EQ(next_look(plan, plan.count()), plan.count());
  EXPECT_EQ(next_look(PassPlan(10, 256), 1), 3U) << "all of it, where there is no look";
}

TEST(NoiseLooks, PassesWithinSoManySamplesAreCounted) {
  const PassPlan plan(100, 256);  // 1, 4, 16, 64, 100
  const std::map<std::int64_t, std::uint32_t> expected{{-1, 0}, {0, 0},  {1, 1},   {15, 2},
                                                       {16, 3}, {99, 4}, {100, 5}, {1000, 5}};
  for (const auto& [samples, passes] : expected)
    EXPECT_EQ(passes_within(plan, samples), passes) << samples;
}

class NoiseStopTest : public ScheduleTest {
 protected:
  /// Ends 1, 4, 16, 64, 256, 512, …
  static JobSpec watched(double threshold, int tiles = 4) {
    JobSpec job = spec(tiles, 4096);
    job.noise_threshold = threshold;
    return job;
  }
  /// Everything that is handed out comes in.
  void render_what_there_is(WorkerId worker) {
    while (!held_[worker].empty()) {
      pass(0.01);
      const GrantLease done = finish_one(worker);
      passes_[done.task.tile] = std::max(passes_[done.task.tile], done.task.pass + 1);
    }
  }
  void expect_passes(std::uint32_t passes) {
    ASSERT_EQ(passes_.size(), 4U);
    for (const auto& [tile, count] : passes_) EXPECT_EQ(count, passes) << tile;
  }
  std::map<std::uint32_t, std::uint32_t> passes_;  // of each tile
};

TEST_F(NoiseStopTest, NoPassBeyondALookBeginsBeforeItsAnswer) {
  add(1, watched(0.01));
  const WorkerId a = join("a");
  ready(a);
  render_what_there_is(a);
  expect_passes(3);
  ASSERT_EQ(asked_.size(), 1U);
  EXPECT_EQ(asked_[0].passes, 3U);
  pass(3);
  EXPECT_TRUE(held_[a].empty());
  take(scheduler_.noise_measured(1, 1, 3, 0.02, now_));
  render_what_there_is(a);
  expect_passes(4);
  ASSERT_EQ(asked_.size(), 2U);
  EXPECT_TRUE(finished_.empty());
}

TEST_F(NoiseStopTest, EndsWhereTheNoiseIsLowEnough) {
  add(1, watched(0.01));
  const WorkerId a = join("a");
  ready(a);
  render_what_there_is(a);
  take(scheduler_.noise_measured(1, 1, 3, 0.02, now_));
  render_what_there_is(a);
  take(scheduler_.noise_measured(1, 1, 3, 0, now_));
  EXPECT_TRUE(finished_.empty()) << "of a look that is long over";
  take(scheduler_.noise_measured(1, 1, 4, 0.01, now_));
  ASSERT_EQ(finished_, std::vector<JobId>{1});
  EXPECT_EQ(shortened_[1], 64);
  expect_passes(4);
  const JobView view = *scheduler_.job(1, now_);
  EXPECT_EQ(view.state, "done");
  EXPECT_EQ(view.tasks, view.tasks_done);
}

TEST_F(NoiseStopTest, MakesAllItsSamplesWhereItStaysNoisy) {
  add(1, watched(0.01));
  const WorkerId a = join("a");
  ready(a);
  for (std::size_t looks = 0; finished_.empty(); ++looks) {
    render_what_there_is(a);
    if (!finished_.empty()) break;
    ASSERT_EQ(asked_.size(), looks + 1);
    take(scheduler_.noise_measured(1, 1, asked_.back().passes, 1, now_));
  }
  expect_passes(plans_[1]->passes.count());
  EXPECT_TRUE(shortened_.empty());
}

TEST_F(NoiseStopTest, AStartAsksAgainAndGoesOnWhereAPassWasBegun) {
  for (const bool begun : {false, true}) {
    const JobId job = begun ? 2 : 1;
    plans_[job] = std::make_shared<const JobPlan>(watched(0.01));
    take(scheduler_.add_job(job, plans_[job], now_));
    for (std::uint32_t tile = 0; tile < 4; ++tile)
      for (std::uint32_t pass = 0; pass < (begun && tile == 2 ? 5U : 4U); ++pass)
        scheduler_.restore_closed(job, {1, tile, pass});
    for (std::uint32_t tile = 0; tile < 4; ++tile)
      take(scheduler_.tile_folded(job, 1, tile, begun && tile == 2 ? 5 : 4, now_));
    EXPECT_EQ(asked_.size(), 1U) << "at 64 samples, unless the next pass says what came of it";
  }
  EXPECT_EQ(asked_[0].job, 1U);
  EXPECT_EQ(asked_[0].passes, 4U);
  const WorkerId a = join("a");
  ready(a, 2);
  const JobId next = held_[a].at(0).job;
  EXPECT_EQ(next, 2U) << "the other waits for its look";
}

TEST_F(NoiseStopTest, TogetherWithATimeLimitEitherEndsIt) {
  JobSpec both = watched(0.01);
  both.time_limit_seconds = 3600;
  add(1, both);
  const WorkerId a = join("a");
  ready(a);
  render_what_there_is(a);
  ASSERT_EQ(asked_.size(), 1U);
  take(scheduler_.noise_measured(1, 1, 3, 0.005, now_));
  EXPECT_EQ(finished_, std::vector<JobId>{1});
  EXPECT_EQ(shortened_[1], 16);
}

}  // namespace
}  // namespace tessera::server
