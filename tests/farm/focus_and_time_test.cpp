// What decides which task comes next and which pass is the last changes no bit of what is made.
#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/job/pass_plan.hpp"
#include "tests/farm/farm.hpp"
#include "tests/farm/reference.hpp"

namespace tessera::farm_test {
namespace {

constexpr std::int64_t asked = 1'000'000;
constexpr int pass_most = 16;

/// Far more samples than `flag` will let it take, in passes that are soon over.
std::vector<std::string> ended_by(const std::string& flag, const std::string& value) {
  return {"--size",    "96x64",
          "--samples", std::to_string(asked),
          "--pass",    std::to_string(pass_most),
          "--tile",    "16",
          flag,        value};
}

/// How many is the machine's speed; that a pass of the job ends there holds at any.
bool ends_a_pass(std::int64_t samples) {
  const PassPlan plan(asked, pass_most);
  for (std::uint32_t pass = 0; pass < plan.count() && plan.pass(pass).end() <= samples; ++pass)
    if (plan.pass(pass).end() == samples) return true;
  return false;
}

/// The samples that the job came to, and that a job submitted with these has the same bits.
std::int64_t expect_as_submitted(Farm& farm, const std::string& id) {
  const image::ExrImage picture = farm.finish(id);
  const auto job = farm.job(id);
  const auto samples = job.value("samples", std::int64_t{0});
  EXPECT_EQ(job.value("state", ""), "done");
  EXPECT_EQ(job.value("progress", 0.0), 1.0);
  EXPECT_LT(samples, asked);
  EXPECT_TRUE(ends_a_pass(samples)) << samples << farm.logs();
  for (const float n : picture.plane("samples")) {
    if (n != static_cast<float>(samples)) {
      ADD_FAILURE() << "a pixel has " << n << " of " << samples << " samples";
      break;
    }
  }
  Farm other;
  other.add_worker();
  const image::ExrImage submitted = other.finish(
      other.submit(scene_path(), {"--size", "96x64", "--samples", std::to_string(samples), "--pass",
                                  std::to_string(pass_most), "--tile", "16"}));
  const auto different = image::difference(submitted, picture);
  EXPECT_FALSE(different.has_value()) << different.value_or("");
  return samples;
}

TEST(TimeLimit, ends_at_a_whole_pass_with_the_bits_of_a_job_of_so_many_samples) {
  Farm farm;
  farm.add_worker();
  farm.add_worker();
  const std::string id = farm.submit(scene_path(), ended_by("--time", "3"));
  expect_as_submitted(farm, id);
}

TEST(TimeLimit, survives_a_restart_of_the_coordinator) {
  Farm farm;
  farm.add_worker();
  const std::string id = farm.submit(scene_path(), ended_by("--time", "4"));
  ASSERT_TRUE(farm.wait_for_progress(id, 1e-6)) << farm.logs();
  farm.kill_and_restart_server();
  const std::int64_t samples = expect_as_submitted(farm, id);
  farm.kill_and_restart_server();
  EXPECT_EQ(farm.job(id).value("samples", std::int64_t{0}), samples);
  EXPECT_EQ(farm.job(id).value("state", ""), "done");
}

TEST(Noise, ends_a_job_at_the_same_pass_with_the_same_bits_for_any_number_of_workers) {
  std::optional<image::ExrImage> first;
  for (const int workers : {1, 2, 5}) {
    Farm farm;
    for (int i = 0; i < workers; ++i) farm.add_worker();
    const std::string id = farm.submit(scene_path(), ended_by("--noise", "0.07"));
    if (workers == 2) {
      const std::int64_t samples = expect_as_submitted(farm, id);
      EXPECT_GT(samples, 16);
      continue;
    }
    const image::ExrImage picture = farm.finish(id);
    if (!first) first = picture;
    const auto different = image::difference(*first, picture);
    EXPECT_FALSE(different.has_value()) << different.value_or("");
  }
}

TEST(Noise, ends_a_job_at_the_same_pass_though_the_coordinator_is_killed) {
  std::array<std::int64_t, 2> samples{};
  for (const bool killed : {false, true}) {
    Farm farm;
    farm.add_worker();
    const std::string id = farm.submit(scene_path(), ended_by("--noise", "0.1"));
    if (killed) {
      ASSERT_TRUE(farm.wait_for_progress(id, 16.0 / asked)) << farm.logs();
      farm.kill_and_restart_server();
    }
    samples.at(killed ? 1 : 0) = expect_as_submitted(farm, id);
  }
  EXPECT_EQ(samples[0], samples[1]);
}

TEST(Crop, has_the_whole_pictures_bits_where_it_is) {
  Farm farm;
  farm.add_worker();
  farm.add_worker();
  std::vector<std::string> arguments{"--size", "96x64", "--samples", "20", "--tile", "16"};
  const image::ExrImage whole = farm.finish(farm.submit(scene_path(), arguments));
  for (const char* more : {"--crop", "21,9,40,33", "--order", "center", "--focus", "8x8+30+20"})
    arguments.emplace_back(more);
  const image::ExrImage part = farm.finish(farm.submit(scene_path(), arguments));
  ASSERT_EQ(part.width, 40);
  ASSERT_EQ(part.height, 33);
  for (const std::string& channel : whole.channels) {
    if (image::is_diagnostic(channel)) continue;
    for (std::size_t y = 0; y < 33; ++y)
      for (std::size_t x = 0; x < 40; ++x)
        ASSERT_EQ(part.plane(channel)[40 * y + x], whole.plane(channel)[96 * (y + 9) + x + 21])
            << channel << ' ' << x << ' ' << y;
  }
}

TEST(Focus, and_order_change_no_bit_though_it_is_moved_and_the_coordinator_killed) {
  const PictureJob job{};
  Farm farm;
  farm.add_worker();
  std::vector<std::string> arguments = arguments_of(job);
  for (const char* more : {"--order", "center", "--focus", "40x30+100+50", "--max-workers", "2"})
    arguments.emplace_back(more);
  const std::string id = farm.submit(scene_path(), arguments);
  const auto focus = [&] { return farm.job(id).value("focus", nlohmann::json()); };
  EXPECT_EQ(focus().value("x", -1), 100);
  ASSERT_TRUE(farm.wait_for_progress(id, 0.02)) << farm.logs();
  const Outcome moved = farm.tessera({"focus", id, "50x131+200+0"});
  ASSERT_EQ(moved.code, 0) << moved.errors;
  EXPECT_EQ(farm.tessera({"set", id, "--priority", "3", "--max-workers", "0"}).code, 0);
  farm.kill_and_restart_server();
  EXPECT_EQ(focus().value("x", -1), 200) << "it survives";
  EXPECT_EQ(farm.job(id).value("priority", 0), 3);
  const Outcome beyond = farm.tessera({"focus", id, "51x131+200+0"});
  EXPECT_EQ(beyond.code, 2);
  EXPECT_NE(beyond.errors.find("from 1 to 50, found 51"), std::string::npos) << beyond.errors;
  EXPECT_EQ(farm.tessera({"focus", id, "none"}).code, 0);
  EXPECT_TRUE(focus().is_null());
  expect_undisturbed(job, farm.finish(id));
}

}  // namespace
}  // namespace tessera::farm_test
