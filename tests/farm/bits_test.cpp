// The exactness contract, on real processes: the same bits whatever workers, tiles, orders, deaths
// and restarts there were.
#include <gtest/gtest.h>
#include <signal.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "tests/farm/farm.hpp"
#include "tests/farm/reference.hpp"
#include "tests/farm/reordering_proxy.hpp"

namespace tessera::farm_test {
namespace {

const PictureJob picture_job;

std::vector<std::string> job_arguments(int tile = 64) {
  PictureJob job;
  job.tile = tile;
  return arguments_of(job);
}

const image::ExrImage& reference() { return undisturbed(picture_job); }

void expect_reference(const image::ExrImage& picture) { expect_undisturbed(picture_job, picture); }

/// From now until the coordinator has given one of two workers up.
double seconds_until_one_worker_is_left(const Farm& farm) {
  const auto started = std::chrono::steady_clock::now();
  EXPECT_TRUE(farm.wait_for_workers(1, Seconds(20))) << farm.logs();
  return Seconds(std::chrono::steady_clock::now() - started).count();
}

TEST(Bits, the_reference_is_a_picture) {
  ASSERT_EQ(reference().width, 250);
  ASSERT_EQ(reference().height, 131);
  double sum = 0;
  for (const float value : reference().plane("G")) sum += value;
  EXPECT_GT(sum / (250 * 131), 0.01);
  for (const float n : reference().plane("samples")) ASSERT_EQ(n, 100.0F);
}

TEST(Bits, are_the_same_with_two_and_five_workers) {
  for (const int count : {2, 5}) {
    SCOPED_TRACE(count);
    Farm farm;
    for (int k = 0; k < count; ++k) farm.add_worker();
    expect_reference(farm.finish(farm.submit(scene_path(), job_arguments())));
  }
}

TEST(Bits, are_the_same_with_more_threads) {
  Farm farm;
  farm.add_worker(3);
  expect_reference(farm.finish(farm.submit(scene_path(), job_arguments())));
}

TEST(Bits, are_the_same_for_tiles_of_16_and_23) {
  Farm farm;
  farm.add_worker(2);
  for (const int tile : {16, 23}) {
    SCOPED_TRACE(tile);
    expect_reference(farm.finish(farm.submit(scene_path(), job_arguments(tile))));
  }
}

TEST(Bits, are_the_same_when_results_arrive_the_slowest_pass_first) {
  Farm farm;
  const ReorderingProxy proxy(farm.listen());
  farm.add_worker(2, proxy.address());
  expect_reference(farm.finish(farm.submit(scene_path(), job_arguments(16))));
  EXPECT_GT(proxy.swapped(), 10) << "the proxy had nothing to reorder";
}

TEST(Bits, are_not_the_same_with_another_seed) {
  Farm farm;
  farm.add_worker(2);
  const auto other = farm.finish(farm.submit(scene_path(), arguments_of({.seed = 1})));
  EXPECT_TRUE(image::difference(reference(), other).has_value());
}

TEST(Bits, are_the_same_when_a_worker_is_killed) {
  Farm farm;
  farm.add_worker();
  farm.add_worker();
  const std::string id = farm.submit(scene_path(), job_arguments());
  ASSERT_TRUE(farm.wait_for_progress(id, 0.05)) << farm.logs();
  ASSERT_LT(farm.job(id).value("progress", 1.0), 1.0) << "too late to disturb";
  farm.workers()[0].kill();
  EXPECT_LT(seconds_until_one_worker_is_left(farm), 1.0) << "its work goes out again at once";
  expect_reference(farm.finish(id));
}

TEST(Bits, are_the_same_when_a_worker_stops_for_ten_seconds) {
  Farm farm;
  farm.add_worker();
  farm.add_worker();
  const std::string id = farm.submit(scene_path(), job_arguments());
  ASSERT_TRUE(farm.wait_for_progress(id, 0.05)) << farm.logs();
  ASSERT_LT(farm.job(id).value("progress", 1.0), 1.0) << "too late to disturb";
  const auto stopped = std::chrono::steady_clock::now();
  farm.workers()[0].signal(SIGSTOP);
  EXPECT_LT(seconds_until_one_worker_is_left(farm), 5.0) << "its work goes out again within 5 s";
  expect_reference(farm.finish(id));  // without the stopped one, which still holds its leases
  std::this_thread::sleep_until(stopped + std::chrono::seconds(10));
  farm.workers()[0].signal(SIGCONT);
  EXPECT_TRUE(farm.wait_for_workers(2, Seconds(10))) << farm.logs();
  expect_reference(farm.finish(id));
  EXPECT_TRUE(farm.workers()[0].running()) << "it should have come back";
}

TEST(Bits, are_the_same_when_the_coordinator_is_killed_and_started_again) {
  Farm farm;
  farm.add_worker();
  farm.add_worker();
  const std::string id = farm.submit(scene_path(), job_arguments());
  for (const double progress : {0.05, 0.4}) {
    ASSERT_TRUE(farm.wait_for_progress(id, progress)) << farm.logs();
    ASSERT_LT(farm.job(id).value("progress", 1.0), 1.0) << "too late to disturb";
    farm.kill_and_restart_server();
  }
  expect_reference(farm.finish(id));
}

}  // namespace
}  // namespace tessera::farm_test
