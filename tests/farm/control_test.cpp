// What people see of failures, and how they keep workers from work, from the command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "tests/farm/farm.hpp"
#include "tests/farm/reference.hpp"

namespace tessera::farm_test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// Until the worker has written it on standard error; false after 10 s.
bool says(const Process& worker, const std::string& text) {
  return becomes_true([&] { return worker.errors().find(text) != std::string::npos; }, Seconds(10));
}

json only_worker(const Farm& farm) { return farm.get("/v1/workers").at("workers").at(0); }

TEST(Control, a_worker_is_quarantined_released_and_drained_by_its_name_and_told_why) {
  Farm farm;
  farm.add_worker();
  ASSERT_TRUE(farm.wait_for_workers(1, Seconds(20))) << farm.logs();
  const Outcome barred =
      farm.tessera({"--json", "quarantine", "worker-0", "--reason", "its fan is broken"});
  EXPECT_EQ(barred.code, 0) << barred.errors;
  EXPECT_EQ(json::parse(barred.output).at("name"), "worker-0");
  EXPECT_EQ(only_worker(farm).at("reason"), "its fan is broken");
  EXPECT_TRUE(says(farm.workers()[0], "this worker is quarantined: its fan is broken"))
      << farm.logs();

  EXPECT_EQ(farm.tessera({"release", "worker-0"}).code, 0);
  EXPECT_EQ(only_worker(farm).at("state"), "idle");
  EXPECT_TRUE(says(farm.workers()[0], "released")) << farm.logs();

  const std::string number = std::to_string(only_worker(farm).at("id").get<int>());
  EXPECT_EQ(farm.tessera({"drain", number}).code, 0);
  EXPECT_EQ(farm.workers()[0].wait(Seconds(20)), 0) << farm.logs();
}

TEST(Control, a_quarantine_outlives_coordinator_and_worker_and_is_ended_though_nobody_is_there) {
  Farm farm;
  farm.add_worker();
  ASSERT_TRUE(farm.wait_for_workers(1, Seconds(20))) << farm.logs();
  ASSERT_EQ(farm.tessera({"quarantine", "worker-0", "--reason", "its fan is broken"}).code, 0);
  farm.kill_and_restart_server();
  farm.kill_and_restart_worker(0);
  ASSERT_TRUE(farm.wait_for_workers(1, Seconds(20))) << farm.logs();
  EXPECT_EQ(only_worker(farm).at("state"), "quarantined");
  EXPECT_EQ(only_worker(farm).at("quarantine").at("by"), "user");
  farm.workers()[0].signal(SIGTERM);
  ASSERT_TRUE(farm.wait_for_workers(0, Seconds(20))) << farm.logs();
  const Outcome table = farm.tessera({"workers"});
  EXPECT_THAT(table.output, HasSubstr("worker-0"));
  EXPECT_THAT(table.output, HasSubstr("its fan is broken"));
  EXPECT_EQ(farm.tessera({"release", "worker-0"}).code, 0);
  EXPECT_TRUE(farm.get("/v1/quarantines").at("quarantines").empty());
  EXPECT_EQ(farm.tessera({"release", "worker-0"}).code, 1);
}

TEST(Control, a_job_that_has_ended_is_purged_and_one_under_way_is_not) {
  Farm farm;
  const std::string id = farm.submit(scene_path(), arguments_of({}));
  const Outcome early = farm.tessera({"purge", id});
  EXPECT_EQ(early.code, 1);
  EXPECT_THAT(early.errors, HasSubstr("cancel it first"));
  farm.add_worker();
  EXPECT_EQ(farm.tessera({"wait", id}).code, 0) << farm.logs();
  EXPECT_EQ(farm.tessera({"cancel", id}).code, 1) << "its pictures stay";
  EXPECT_EQ(farm.job(id).at("state"), "done");
  EXPECT_EQ(farm.tessera({"purge", id}).code, 0);
  EXPECT_EQ(farm.get("/v1/jobs/" + id).at("status"), 404);
  EXPECT_EQ(farm.tessera({"purge", id}).code, 1);
  farm.kill_and_restart_server();
  EXPECT_TRUE(farm.get("/v1/jobs").at("jobs").empty());
}

TEST(Control, a_worker_that_is_not_there_is_named_with_the_nearest) {
  Farm farm;
  farm.add_worker();
  ASSERT_TRUE(farm.wait_for_workers(1, Seconds(20))) << farm.logs();
  const Outcome outcome = farm.tessera({"drain", "wroker-0"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.errors, HasSubstr("\"worker-0\""));
}

TEST(Control, attempts_that_were_lost_are_listed_with_worker_task_and_reason_after_a_restart) {
  const PictureJob picture{.tile = 32};
  Farm farm;
  farm.add_worker();
  const std::string id = farm.submit(scene_path(), arguments_of(picture));
  ASSERT_TRUE(farm.wait_for_progress(id, 0.1)) << farm.logs();
  ASSERT_EQ(farm.job(id).at("failures"), 0);
  farm.kill_and_restart_worker(0);
  expect_undisturbed(picture, farm.finish(id));
  farm.kill_and_restart_server();
  EXPECT_EQ(farm.job(id).at("failures"), 1);
  const json answer = json::parse(farm.tessera({"--json", "failures", id}).output);
  ASSERT_EQ(answer.at("failures").size(), 1U) << answer;
  const json failure = answer.at("failures").at(0);
  EXPECT_EQ(failure.at("outcome"), "lost");
  EXPECT_EQ(failure.at("worker"), "worker-0");
  EXPECT_EQ(failure.at("frame"), 1);
  EXPECT_EQ(failure.at("reason"), "its connection ended without a word");
  const Outcome table = farm.tessera({"failures", id});
  EXPECT_THAT(table.output, HasSubstr("OUTCOME"));
  EXPECT_THAT(table.output, HasSubstr("worker-0"));
}

TEST(Control, what_a_worker_could_not_do_is_listed_with_its_log) {
  Farm farm;
  farm.add_worker();
  const std::string id = farm.submit(scene_path(), arguments_of({}));
  (void)farm.tessera({"wait", id});
  // The same job of a scene that the worker cannot read: what it says is kept.
  json spec = farm.job(id).at("spec");
  spec["camera"] = "there is no such camera";
  const json posted = farm.send("POST", "/v1/jobs", spec);
  ASSERT_TRUE(posted.contains("id")) << posted;
  const std::string broken = std::to_string(posted.at("id").get<int>());
  EXPECT_EQ(farm.tessera({"wait", broken}).code, 1);
  const json failures = farm.get("/v1/jobs/" + broken + "/failures");
  ASSERT_GE(failures.at("count").get<int>(), 1) << failures;
  const json newest = failures.at("failures").at(0);
  EXPECT_EQ(newest.at("outcome"), "failed");
  EXPECT_TRUE(newest.at("tile").is_null()) << newest;
  EXPECT_THAT(newest.at("log").get<std::string>(), HasSubstr("could not be prepared"));
}

}  // namespace
}  // namespace tessera::farm_test
