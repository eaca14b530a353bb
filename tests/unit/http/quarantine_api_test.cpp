// Names whose workers are kept from work, over HTTP; and jobs that are removed.
#include <gmock/gmock.h>

#include "api_fixture.hpp"

namespace tessera::server {
namespace {

using testing::HasSubstr;

class QuarantineApiTest : public ApiTest {
 protected:
  QuarantineApiTest() {
    WorkerView worker;
    worker.id = 4;
    worker.info.name = "node 4";
    worker.state = "idle";
    coordinator.connected.push_back(worker);
  }
};

TEST_F(QuarantineApiTest, ANameIsQuarantinedWhetherItsWorkerIsThereOrNotAndShownWithWhoWhenAndWhy) {
  const HttpResponse made =
      ask("PUT", "/v1/quarantines/node%204", R"({"reason":"its fan is broken"})");
  EXPECT_EQ(made.status, 201U);
  EXPECT_EQ(ask("PUT", "/v1/quarantines/node%204", R"({"reason":"its fan is broken"})").status,
            200U)
      << "a repetition changes nothing";
  EXPECT_EQ(ask("PUT", "/v1/quarantines/away", "{}").status, 201U);
  const Json all = json(ask("GET", "/v1/workers"));
  const Json& worker = all["workers"][0];
  EXPECT_EQ(worker["state"], "quarantined");
  EXPECT_EQ(worker["quarantine"]["reason"], "its fan is broken");
  EXPECT_EQ(worker["quarantine"]["by"], "user");
  EXPECT_EQ(worker["quarantine"]["durable"], true);
  EXPECT_THAT(worker["quarantine"]["since"].get<std::string>(), HasSubstr("2023-11-14T"));
  ASSERT_EQ(all["quarantines"].size(), 2U);
  EXPECT_EQ(all["quarantines"][1]["name"], "away");
  EXPECT_EQ(json(ask("GET", "/v1/quarantines"))["quarantines"], all["quarantines"]);
}

TEST_F(QuarantineApiTest, ANameIsReleasedOnceAndTheNearestIsSaidForOneThatIsNotQuarantined) {
  ask("PUT", "/v1/quarantines/away", "{}");
  const HttpResponse wrong = ask("DELETE", "/v1/quarantines/awya");
  EXPECT_EQ(wrong.status, 404U);
  EXPECT_THAT(json(wrong)["detail"].get<std::string>(), HasSubstr("\"away\""));
  EXPECT_EQ(json(ask("DELETE", "/v1/quarantines/away"))["name"], "away");
  EXPECT_EQ(ask("DELETE", "/v1/quarantines/away").status, 404U);
  EXPECT_TRUE(json(ask("GET", "/v1/workers"))["workers"][0]["quarantine"].is_null());
}

TEST_F(QuarantineApiTest, WhatTheFullDiskDoesNotKeepIs507WithWhatToDo) {
  coordinator.full = "the database could not be used: database or disk is full";
  const HttpResponse refused = ask("PUT", "/v1/quarantines/away", "{}");
  EXPECT_EQ(refused.status, 507U);
  EXPECT_THAT(json(refused)["detail"].get<std::string>(), HasSubstr("tessera purge"));
}

TEST_F(QuarantineApiTest, AJobIsRemovedOnlyIfThatIsAskedForAndItHasEnded) {
  coordinator.add(1, "rendering");
  coordinator.add(2, "done");
  EXPECT_EQ(ask("DELETE", "/v1/jobs/2").status, 409U)
      << "a cancel that is repeated must not take the pictures away";
  EXPECT_EQ(ask("DELETE", "/v1/jobs/1?purge=true").status, 409U);
  EXPECT_EQ(ask("DELETE", "/v1/jobs/2?purge=1").status, 400U);
  EXPECT_EQ(ask("DELETE", "/v1/jobs/2?purge=false").status, 409U);
  EXPECT_EQ(ask("GET", "/v1/jobs/2").status, 200U);
  EXPECT_EQ(json(ask("DELETE", "/v1/jobs/2?purge=true"))["id"], 2);
  EXPECT_EQ(ask("DELETE", "/v1/jobs/2?purge=true").status, 404U);
}

}  // namespace
}  // namespace tessera::server
