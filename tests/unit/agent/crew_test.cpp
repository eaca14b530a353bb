#include "worker/agent/crew.hpp"

#include <gtest/gtest.h>

#include <string>
#include <thread>

#include "common/image/tile.hpp"
#include "tests/unit/agent/fakes.hpp"

namespace tessera::agent {
namespace {

using namespace std::chrono_literals;

class CrewTest : public testing::Test {
 protected:
  std::shared_ptr<const JobPlan> plan = std::make_shared<const JobPlan>(test_spec());
  std::shared_ptr<const PreparedScene> scene = std::make_shared<FakeScene>();
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<TaskEnd> ends;

  TaskOrder order(std::uint32_t tile, std::uint32_t pass = 0) const {
    return {.lease = {1, 100U * pass + tile},
            .job = {1, plan->digest},
            .task = {1, tile, pass},
            .plan = plan,
            .scene = scene};
  }
  Crew::OnEnd on_end() {
    return [this](TaskEnd end) {
      const std::lock_guard lock(mutex);
      ends.push_back(std::move(end));
      changed.notify_all();
    };
  }
  bool wait_for(std::size_t count) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, 10s, [&] { return ends.size() >= count; });
  }
  static Crew::OnProgress no_progress() {
    return [](const LeaseId&, double) {};
  }
};

TEST_F(CrewTest, tiles_come_back_encoded_and_in_order) {
  FakeRenderer renderer(1);
  Crew crew(renderer, on_end(), no_progress());
  for (std::uint32_t tile = 0; tile < 10; ++tile) crew.give(order(tile, 1));
  ASSERT_TRUE(wait_for(10));
  for (std::uint32_t tile = 0; tile < 10; ++tile) {
    EXPECT_EQ(ends[tile].what, TaskEnd::What::done);
    EXPECT_EQ(ends[tile].lease.number, 100 + tile);
    EXPECT_EQ(ends[tile].stats.samples, 16 * 16 * 3);
    const image::TileImage image =
        image::decode_tile(*ends[tile].bytes, {.window = plan->grid.tile(tile),
                                               .film_width = 64,
                                               .film_height = 48,
                                               .samples = 3,
                                               .aovs = true});
    EXPECT_EQ(image.window, plan->grid.tile(tile));
  }
  EXPECT_EQ(crew.stats().tasks, 10);
}

TEST_F(CrewTest, small_tasks_are_rendered_one_a_thread_and_large_ones_two_at_once) {
  EXPECT_EQ(tasks_at_once(256, 1), 1);
  EXPECT_EQ(tasks_at_once(256, 8), 8);
  EXPECT_EQ(tasks_at_once(4096 * 256, 8), 2);
  EXPECT_EQ(tasks_at_once(4096 * 256, 1), 1);
  EXPECT_EQ(tasks_at_once(1, 64), 64);
  EXPECT_EQ(tasks_at_once(64 * 16384 / 8, 64), 9);
}

TEST_F(CrewTest, as_many_tasks_as_fit_run_at_once_and_no_more) {
  FakeRenderer renderer(4);
  renderer.delay = 20ms;
  Crew crew(renderer, on_end(), no_progress());
  std::uint32_t given = 0;
  for (; crew.wants_more() && given < 100; ++given) crew.give(order(given % 12, given / 12));
  EXPECT_EQ(given, 5U) << "four that begin and one that waits";
  for (std::uint32_t more = given; more < 12; ++more) crew.give(order(more));
  ASSERT_TRUE(wait_for(12));
  EXPECT_EQ(renderer.most_active, 4);
}

TEST_F(CrewTest, stopped_tasks_end_as_stopped_whether_they_render_or_wait) {
  FakeRenderer renderer(1);
  renderer.hold = true;
  Crew crew(renderer, on_end(), no_progress());
  crew.give(order(0));
  crew.give(order(1));
  crew.stop(order(1).lease);
  crew.stop(order(0).lease);
  ASSERT_TRUE(wait_for(2));
  EXPECT_EQ(ends[0].what, TaskEnd::What::stopped);
  EXPECT_EQ(ends[1].what, TaskEnd::What::stopped);
  EXPECT_LE(renderer.order.size(), 1U) << "what waited was never begun";
}

TEST_F(CrewTest, a_failure_carries_its_reason) {
  FakeRenderer renderer(1);
  renderer.render_error = "the scene is cursed";
  Crew crew(renderer, on_end(), no_progress());
  crew.give(order(0));
  ASSERT_TRUE(wait_for(1));
  EXPECT_EQ(ends[0].what, TaskEnd::What::failed);
  EXPECT_EQ(ends[0].code, "render");
  EXPECT_EQ(ends[0].reason, "the scene is cursed");
}

TEST_F(CrewTest, the_end_of_the_crew_stops_what_renders) {
  FakeRenderer renderer(2);
  renderer.hold = true;
  {
    Crew crew(renderer, on_end(), no_progress());
    for (std::uint32_t tile = 0; tile < 6; ++tile) crew.give(order(tile));
  }
  EXPECT_EQ(ends.size(), 6U);
  for (const TaskEnd& end : ends) EXPECT_EQ(end.what, TaskEnd::What::stopped);
}

TEST_F(CrewTest, every_wait_between_two_tasks_is_counted) {
  FakeRenderer renderer(1);
  renderer.delay = 1ms;
  Crew crew(renderer, on_end(), no_progress());
  for (std::uint32_t i = 0; i < 24; ++i) crew.give(order(i % 12, i / 12));
  ASSERT_TRUE(wait_for(24));
  // The last tile may be encoded before its lane has said that it rendered it.
  while (crew.stats().tasks < 24) std::this_thread::yield();
  const CrewStats stats = crew.stats();
  EXPECT_EQ(stats.tasks, 24);
  EXPECT_EQ(stats.gaps, 23);
  EXPECT_GT(stats.gap_seconds, 0);
  EXPECT_GE(stats.gap_seconds, stats.gap_most);
}

}  // namespace
}  // namespace tessera::agent
