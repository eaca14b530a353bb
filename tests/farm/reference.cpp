#include "tests/farm/reference.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <tuple>

namespace tessera::farm_test {

PictureJob lasting(Seconds time, PictureJob job) {
  Farm farm;
  farm.add_worker();
  farm.add_worker();
  EXPECT_TRUE(farm.wait_for_workers(2, Seconds(30))) << farm.logs();
  PictureJob probe = job;
  probe.samples = 64;
  const auto start = std::chrono::steady_clock::now();
  farm.finish(farm.submit(scene_path(), arguments_of(probe)));
  const Seconds taken = std::chrono::steady_clock::now() - start;
  const double samples = probe.samples * std::max(1.0, time / taken);
  job.samples = static_cast<int>(std::min(samples, 20000.0));
  return job;
}

std::string scene_path() { return (sources() / "scenes/cornell.json").string(); }

std::vector<std::string> arguments_of(const PictureJob& job) {
  return {"--size",    std::to_string(job.width) + "x" + std::to_string(job.height),
          "--samples", std::to_string(job.samples),
          "--tile",    std::to_string(job.tile),
          "--seed",    std::to_string(job.seed)};
}

const image::ExrImage& undisturbed(const PictureJob& job) {
  using Key = std::tuple<int, int, int, int>;
  static std::map<Key, image::ExrImage> pictures;
  const Key key{job.width, job.height, job.samples, job.seed};
  const auto known = pictures.find(key);
  if (known != pictures.end()) return known->second;
  Farm farm;
  farm.add_worker();
  PictureJob plain = job;
  plain.tile = 64;
  image::ExrImage picture = farm.finish(farm.submit(scene_path(), arguments_of(plain)));
  return pictures.emplace(key, std::move(picture)).first->second;
}

void expect_undisturbed(const PictureJob& job, const image::ExrImage& picture) {
  const auto different = image::difference(undisturbed(job), picture);
  EXPECT_FALSE(different.has_value()) << different.value_or("");
}

}  // namespace tessera::farm_test
