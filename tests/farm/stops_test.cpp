// Processes that stand still and go on, as under a debugger, a suspended machine, a stalled disk.
#include <gtest/gtest.h>
#include <signal.h>

#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "tests/farm/farm.hpp"
#include "tests/farm/reference.hpp"

namespace tessera::farm_test {
namespace {

void stand_still(const Process& process, Seconds time) {
  process.signal(SIGSTOP);
  std::this_thread::sleep_for(time);
  process.signal(SIGCONT);
}

TEST(Stops, a_coordinator_that_stood_still_blames_no_worker_for_it_and_the_bits_are_the_same) {
  const PictureJob job;
  Farm farm;
  farm.add_worker();
  farm.add_worker();
  const std::string id = farm.submit(scene_path(), arguments_of(job));
  ASSERT_TRUE(farm.wait_for_progress(id, 0.05)) << farm.logs();
  ASSERT_LT(farm.job(id).value("progress", 1.0), 1.0) << "too late to disturb";
  stand_still(farm.server(), Seconds(6));  // a worker that is silent for so long is given up
  expect_undisturbed(job, farm.finish(id));
  EXPECT_EQ(farm.metric("tessera_workers_lost_total"), 0) << farm.logs();
  EXPECT_EQ(farm.get("/v1/workers").at("workers").size(), 2U);
}

TEST(Stops, of_workers_and_coordinator_by_turns_leave_the_same_bits) {
  constexpr std::uint64_t seed = 11;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> how_long(0.05, 1.5), soon(0, 0.02);
  std::uniform_int_distribution<std::size_t> anyone(0, 2);
  const PictureJob job = lasting(Seconds(12), {.tile = 16});
  Farm farm;
  farm.add_worker();
  farm.add_worker();
  const std::string id = farm.submit(scene_path(), arguments_of(job));
  for (int stop = 1; stop <= 8; ++stop) {
    ASSERT_TRUE(farm.wait_for_progress(id, 0.1 * stop)) << farm.logs();
    std::this_thread::sleep_for(Seconds(soon(random)));
    ASSERT_EQ(farm.job(id).value("state", ""), "rendering") << "too late to disturb";
    const std::size_t victim = anyone(random);
    const double time = how_long(random);
    stand_still(victim == 2 ? farm.server() : farm.workers()[victim], Seconds(time));
  }
  expect_undisturbed(job, farm.finish(id));
}

}  // namespace
}  // namespace tessera::farm_test
