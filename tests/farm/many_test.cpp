// Many at once: a thousand workers' connections, a hundred jobs.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/farm/crowd.hpp"
#include "tests/farm/farm.hpp"
#include "tests/farm/reference.hpp"

namespace tessera::farm_test {
namespace {

using nlohmann::json;

TEST(Many, a_thousand_workers_at_once_each_have_work_and_leave_the_bits_of_one) {
  constexpr std::size_t workers = 1000;
  // Two passes of 1,024 tiles: as many tasks as there are leases to begin with.
  const std::vector<std::string> job{"--size", "512x512", "--tile", "16", "--samples", "4"};
  Farm farm;
  image::ExrImage by_one, by_many;
  {
    const Crowd one(farm.listen(), 1);
    by_one = farm.finish(farm.submit(scene_path(), job));
  }
  {
    const Crowd crowd(farm.listen(), workers);
    ASSERT_TRUE(crowd.wait_for_welcomes(workers, Seconds(60))) << crowd.troubles() << farm.logs();
    EXPECT_EQ(farm.get("/v1/workers").at("workers").size(), workers);
    by_many = farm.finish(farm.submit(scene_path(), job));
    // Not that a result of each was accepted: where one is late, copies may win its tasks.
    EXPECT_TRUE(crowd.wait_for_work(workers, Seconds(60))) << "workers without work";
    EXPECT_EQ(crowd.troubles(), "");
  }
  const auto different = image::difference(by_one, by_many);
  EXPECT_FALSE(different.has_value()) << different.value_or("");
}

TEST(Many, a_hundred_jobs_at_once_have_the_bits_of_jobs_alone) {
  constexpr int jobs = 100, kinds = 4;
  const auto kind = [](int number) {
    return PictureJob{.width = 50, .height = 37, .samples = 20, .tile = 16, .seed = number % kinds};
  };
  for (int number = 0; number < kinds; ++number) undisturbed(kind(number));
  Farm farm;
  // The first uploads the scene; the others are posted as it was described.
  std::vector<std::string> ids{farm.submit(scene_path(), arguments_of(kind(0)))};
  json spec = farm.job(ids.front()).at("spec");
  for (int number = 1; number < jobs; ++number) {
    spec["render"]["seed"] = kind(number).seed;
    spec["name"] = "job " + std::to_string(number);
    const json posted = farm.send("POST", "/v1/jobs", spec);
    ASSERT_TRUE(posted.is_object() && posted.contains("id")) << posted << farm.logs();
    ids.push_back(std::to_string(posted.at("id").get<int>()));
  }
  farm.add_worker();
  farm.add_worker();
  for (int number = 0; number < jobs; ++number) {
    SCOPED_TRACE(number);
    expect_undisturbed(kind(number), farm.finish_quickly(ids[static_cast<std::size_t>(number)]));
  }
}

}  // namespace
}  // namespace tessera::farm_test
