// SIGKILL of workers and of the coordinator at random instants of one frame.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "tests/farm/farm.hpp"
#include "tests/farm/reference.hpp"

namespace tessera::farm_test {
namespace {

constexpr std::size_t worker_count = 3;
constexpr int kills = 50;

/// Where in the frame the kills come, by its progress, ascending.
std::vector<double> instants(std::mt19937_64& random) {
  std::uniform_real_distribution<double> anywhere(0.01, 0.9);
  std::vector<double> places;
  for (int k = 0; k < kills; ++k) places.push_back(anywhere(random));
  std::sort(places.begin(), places.end());
  return places;
}

/// What the coordinator has acknowledged is there after every restart.
void kill_the_coordinator(Farm& farm, const std::string& id, bool successor_too, Seconds wait) {
  const nlohmann::json before = farm.job(id);
  if (successor_too) {
    farm.kill_server_and_its_successor_after(wait);
  } else {
    farm.kill_and_restart_server();
  }
  const nlohmann::json after = farm.job(id);
  ASSERT_TRUE(before.is_object() && after.is_object()) << farm.logs();
  EXPECT_GE(after.at("tasks_done").get<int>(), before.at("tasks_done").get<int>());
}

TEST(Kills, fifty_in_one_frame_leave_the_same_bits_and_count_every_sample_once) {
  constexpr std::uint64_t seed = 4;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> soon(0, 0.01), while_starting(0, 0.06);
  std::uniform_int_distribution<std::size_t> anyone(0, worker_count);
  const PictureJob job{.tile = 16};
  Farm farm;
  for (std::size_t k = 0; k < worker_count; ++k) farm.add_worker();
  const std::string id = farm.submit(scene_path(), arguments_of(job));
  int of_coordinators = 0;
  for (const double instant : instants(random)) {
    ASSERT_TRUE(farm.wait_for_progress(id, instant)) << farm.logs();
    std::this_thread::sleep_for(Seconds(soon(random)));
    ASSERT_EQ(farm.job(id).value("state", ""), "rendering") << "too late to disturb";
    const std::size_t victim = anyone(random);
    const double wait = while_starting(random);
    if (victim < worker_count) {
      farm.kill_and_restart_worker(victim);
    } else {
      kill_the_coordinator(farm, id, ++of_coordinators % 3 == 0, Seconds(wait));
    }
  }
  EXPECT_GT(of_coordinators, 5);
  expect_undisturbed(job, farm.finish(id));

  const nlohmann::json done = farm.job(id);
  std::int64_t samples = 0;
  for (const auto& share : done.at("shares")) samples += share.at("samples").get<std::int64_t>();
  EXPECT_EQ(samples, done.at("samples_total").get<std::int64_t>());
}

}  // namespace
}  // namespace tessera::farm_test
