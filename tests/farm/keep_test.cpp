// What is kept goes on: more samples for a finished job, over kills; ranges of frames by name.
#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/farm/farm.hpp"
#include "tests/farm/reference.hpp"

namespace tessera::farm_test {
namespace {

using testing::HasSubstr;

PictureJob with_samples(int samples) {
  PictureJob job;
  job.width = 100;
  job.height = 60;
  job.samples = samples;
  return job;
}

TEST(Extend, twenty_samples_become_a_hundred_and_three_hundred_with_the_bits_of_fresh_jobs) {
  Farm farm;
  farm.add_worker(2);
  const std::string id = farm.submit(scene_path(), arguments_of(with_samples(20)));
  expect_undisturbed(with_samples(20), farm.finish(id));

  ASSERT_EQ(farm.tessera({"extend", id, "--samples", "100"}).code, 0) << farm.logs();
  ASSERT_TRUE(farm.wait_for_progress(id, 0.3));
  farm.kill_and_restart_server();
  expect_undisturbed(with_samples(100), farm.finish(id));

  farm.kill_and_restart_server();
  ASSERT_EQ(farm.tessera({"extend", id, "--samples", "300"}).code, 0) << farm.logs();
  farm.kill_and_restart_server();
  expect_undisturbed(with_samples(300), farm.finish(id));
  EXPECT_EQ(farm.job(id).at("extended_from"), nlohmann::json({20, 100}));
}

TEST(Extend, what_is_not_more_is_refused) {
  Farm farm;
  farm.add_worker(2);
  const std::string id = farm.submit(scene_path(), arguments_of(with_samples(4)));
  static_cast<void>(farm.finish(id));
  for (const char* samples : {"4", "3"}) {
    const Outcome outcome = farm.tessera({"extend", id, "--samples", samples});
    EXPECT_NE(outcome.code, 0);
    EXPECT_THAT(outcome.errors, HasSubstr("expected more samples than the 4"));
  }
  EXPECT_EQ(farm.job(id).at("state"), "done");
}

TEST(Frames, are_rendered_and_fetched_by_their_numbers) {
  Farm farm;
  farm.add_worker(2);
  std::vector<std::string> arguments = arguments_of(with_samples(4));
  arguments.insert(arguments.end(), {"--frames", "1,5,10-12x2"});
  const std::string id = farm.submit(scene_path(), arguments);
  ASSERT_EQ(farm.tessera({"wait", id}).code, 0) << farm.logs();
  EXPECT_EQ(farm.job(id).at("frames_done"), 4);

  const auto pattern = (farm.folder() / "out-###.exr").string();
  ASSERT_EQ(farm.tessera({"fetch", id, "-o", pattern}).code, 0);
  for (const char* name : {"out-001.exr", "out-005.exr", "out-010.exr", "out-012.exr"})
    EXPECT_TRUE(std::filesystem::exists(farm.folder() / name)) << name;
  // Nothing in the scene moves, and the frame's number goes into its noise.
  EXPECT_TRUE(image::difference(image::read_exr_file(farm.folder() / "out-001.exr"),
                                image::read_exr_file(farm.folder() / "out-005.exr")));

  const Outcome unknown = farm.tessera({"fetch", id, "-o", pattern, "--frames", "5-7"});
  EXPECT_EQ(unknown.code, 1);
  EXPECT_THAT(unknown.errors, HasSubstr("has no frames 6-7: it has 1,5,10,12"));
  const Outcome nowhere =
      farm.tessera({"fetch", id, "-o", (farm.folder() / "one.exr").string(), "--frames", "1,5"});
  EXPECT_EQ(nowhere.code, 2);
  EXPECT_THAT(nowhere.errors, HasSubstr("####"));
}

TEST(Storage, is_told_by_the_metrics_and_limited) {
  FarmSettings settings;
  settings.flags = {"--disk-limit", "64K", "--film-memory", "1M"};
  Farm farm(settings);
  EXPECT_EQ(farm.metric("tessera_film_memory_limit_bytes"), 1 << 20);
  EXPECT_EQ(farm.metric("tessera_storage_limit_bytes"), 64 << 10);
  std::vector<std::string> large{"submit", scene_path(), "--size", "200x200"};
  const Outcome film = farm.tessera(large);
  EXPECT_EQ(film.code, 2) << film.errors;
  EXPECT_THAT(film.errors, HasSubstr("--film-memory"));
}

TEST(Storage, takes_no_scene_that_goes_beyond_its_limit) {
  FarmSettings settings;
  settings.flags = {"--disk-limit", "1K"};  // the scene alone is larger
  Farm farm(settings);
  const Outcome refused = farm.tessera({"submit", scene_path()});
  EXPECT_EQ(refused.code, 1) << refused.errors;
  EXPECT_THAT(refused.errors, HasSubstr("--disk-limit"));
  EXPECT_TRUE(farm.get("/v1/jobs").at("jobs").empty());
}

}  // namespace
}  // namespace tessera::farm_test
