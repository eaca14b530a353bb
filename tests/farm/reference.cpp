#include "tests/farm/reference.hpp"

#include <gtest/gtest.h>

#include <map>
#include <tuple>

#include "tests/farm/farm.hpp"

namespace tessera::farm_test {

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
