#include "server/http/views.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "fake_coordinator.hpp"

namespace tessera::server {
namespace {

TEST(Times, AreIso8601InUtc) {
  EXPECT_EQ(iso_time(0), "1970-01-01T00:00:00.000Z");
  EXPECT_EQ(iso_time(951'827'696'007), "2000-02-29T12:34:56.007Z");
}

TEST(JobObject, HasWhatScriptsRelyOn) {
  FakeCoordinator coordinator;
  JobStatus& status = coordinator.add(5);
  status.view.eta_seconds = 12.5;
  status.progress = 0.25;
  status.view.waiting_for = "no worker is connected";
  status.shares.push_back({"node-1", 100});
  const Json job = job_object(status);
  for (const char* key : {"id", "name", "state", "priority", "frames", "samples", "progress",
                          "created", "started", "finished", "eta_seconds", "error"})
    EXPECT_TRUE(job.contains(key)) << key;
  EXPECT_EQ(job["id"], 5);
  EXPECT_EQ(job["samples"], 4);
  EXPECT_EQ(job["progress"], 0.25);
  EXPECT_EQ(job["waiting_for"], "no worker is connected");
  EXPECT_EQ(job["eta_seconds"], 12.5);
  EXPECT_EQ(job["created"], "2023-11-14T22:13:20.000Z");
  EXPECT_EQ(job["frames"]["count"], 1);
  EXPECT_EQ(job["shares"][0]["worker"], "node-1");
}

TEST(JobObject, WhatIsNotYetIsNull) {
  FakeCoordinator coordinator;
  const Json job = job_object(coordinator.add(5));
  EXPECT_TRUE(job["started"].is_null());
  EXPECT_TRUE(job["finished"].is_null());
  EXPECT_TRUE(job["eta_seconds"].is_null());
  EXPECT_TRUE(job["error"].is_null());
  EXPECT_TRUE(job["waiting_for"].is_null());
  EXPECT_TRUE(job["build"].is_null());
}

}  // namespace
}  // namespace tessera::server
