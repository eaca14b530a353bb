// A disk that becomes full under the coordinator, and has room again; one that is read-only at its
// start.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "tests/farm/farm.hpp"
#include "tests/farm/reference.hpp"
#include "tests/farm/small_disk.hpp"

namespace tessera::farm_test {
namespace {

using nlohmann::json;

constexpr std::size_t disk_bytes = 48UL << 20U;
const std::string no_room = "No space left on device";

bool says(const json& value, const std::string& what) {
  return value.is_string() && value.get<std::string>().find(what) != std::string::npos;
}

/// In the database's word, or the system's.
bool says_full(const std::string& what) {
  return what.find("full") != std::string::npos || what.find(no_room) != std::string::npos;
}

FarmSettings on(const SmallDisk& disk) {
  return {.data = disk.folder() / "data", .run_server = disk.inside(), .flags = {}};
}

/// Until the job says what it waits for; false after 20 s.
bool wait_for_reason(const Farm& farm, const std::string& id, const std::string& reason) {
  return becomes_true([&] { return says(farm.job(id).at("waiting_for"), reason); }, Seconds(20));
}

TEST(FullDisk, holds_a_job_up_with_the_reason_and_lets_it_go_on_when_there_is_room) {
  const PictureJob picture{.tile = 32};
  const SmallDisk disk(disk_bytes);
  Farm farm(on(disk));
  farm.add_worker();
  farm.add_worker();
  const std::string id = farm.submit(scene_path(), arguments_of(picture));
  ASSERT_TRUE(farm.wait_for_progress(id, 0.1)) << farm.logs();
  disk.fill();
  ASSERT_LT(farm.job(id).value("progress", 1.0), 1.0) << "too late to disturb";
  EXPECT_TRUE(wait_for_reason(farm, id, no_room)) << farm.job(id) << farm.logs();
  EXPECT_TRUE(says(farm.get("/readyz").at("detail"), no_room)) << farm.get("/readyz");
  EXPECT_NE(farm.server().errors().find(no_room), std::string::npos) << farm.logs();

  const json held = farm.job(id);
  EXPECT_EQ(held.at("state"), "rendering");
  const Outcome fetched =
      farm.tessera({"fetch", id, "-o", (farm.folder() / "so-far.exr").string()});
  EXPECT_EQ(fetched.code, 0) << "what was acknowledged is there to see: " << fetched.errors;
  std::this_thread::sleep_for(Seconds(6));  // the coordinator has looked how much is left
  EXPECT_EQ(farm.job(id).at("tasks_done"), held.at("tasks_done"));
  const Outcome refused = farm.tessera({"submit", scene_path(), "--seed", "7"});
  EXPECT_EQ(refused.code, 1) << refused.errors;
  EXPECT_NE(refused.errors.find("tessera purge"), std::string::npos) << refused.errors;

  disk.make_room();
  expect_undisturbed(picture, farm.finish(id));
  EXPECT_TRUE(farm.job(id).at("waiting_for").is_null());
  EXPECT_EQ(farm.get("/readyz").at("status"), "ready");
}

TEST(FullDisk,
     loses_nothing_that_was_acknowledged_when_the_coordinator_is_killed_and_started_on_it) {
  const PictureJob picture{.tile = 32};
  const SmallDisk disk(disk_bytes);
  Farm farm(on(disk));
  farm.add_worker();
  const std::string id = farm.submit(scene_path(), arguments_of(picture));
  ASSERT_TRUE(farm.wait_for_progress(id, 0.1)) << farm.logs();
  disk.fill();
  ASSERT_TRUE(wait_for_reason(farm, id, no_room)) << farm.logs();
  const json before = farm.job(id);

  // The database may have room where the journal has none.
  const json answer = farm.send("POST", "/v1/jobs", before.at("spec"));
  const bool taken = answer.contains("id");
  if (!taken) {
    EXPECT_EQ(answer.at("status"), 507) << answer;
    EXPECT_TRUE(says_full(answer.at("detail").get<std::string>())) << answer;
  }

  try {
    farm.kill_and_restart_server();
  } catch (const std::runtime_error& error) {
    EXPECT_TRUE(says_full(error.what())) << error.what();
  }
  disk.make_room();
  farm.kill_and_restart_server();
  if (taken) {
    EXPECT_EQ(farm.job(std::to_string(answer.at("id").get<int>())).at("spec"), answer.at("spec"));
    farm.tessera({"cancel", std::to_string(answer.at("id").get<int>())});
  }
  EXPECT_GE(farm.job(id).at("tasks_done").get<int>(), before.at("tasks_done").get<int>());
  expect_undisturbed(picture, farm.finish(id));
}

TEST(ReadOnlyDisk, is_said_at_the_start_and_all_is_there_once_it_can_be_written) {
  const PictureJob picture{.tile = 32};
  const SmallDisk disk(disk_bytes);
  Farm farm(on(disk));
  farm.add_worker();
  const std::string id = farm.submit(scene_path(), arguments_of(picture));
  ASSERT_TRUE(farm.wait_for_progress(id, 0.1)) << farm.logs();
  const json before = farm.job(id);
  farm.server().kill();
  disk.forbid_writing();
  try {
    farm.start_killed_server();
    ADD_FAILURE() << "a coordinator works on a disk that it cannot write";
  } catch (const std::runtime_error& error) {
    const std::string said = error.what();
    EXPECT_NE(said.find("Read-only file system"), std::string::npos) << said;
    EXPECT_NE(said.find((disk.folder() / "data").string()), std::string::npos) << said;
  }
  disk.allow_writing();
  farm.start_killed_server();
  EXPECT_GE(farm.job(id).at("tasks_done").get<int>(), before.at("tasks_done").get<int>());
  expect_undisturbed(picture, farm.finish(id));
}

}  // namespace
}  // namespace tessera::farm_test
