// More samples over HTTP, and what is answered where there is no room.
#include <gmock/gmock.h>

#include "api_fixture.hpp"

namespace tessera::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string spec_text = R"({"name":"cornell","bundle":")" + std::string(64, 'a') +
                              R"(","render":{"width":32,"height":16}})";

TEST_F(ApiTest, AJobIsGivenMoreSamples) {
  coordinator.add(1, "done");
  const Json job = json(ask("PATCH", "/v1/jobs/1", R"({"samples":100})"));
  EXPECT_EQ(job["state"], "queued");
  EXPECT_THAT(coordinator.calls, ElementsAre("extend 100"));
  for (const char* body : {R"({"samples":0})", R"({"samples":"9"})", R"({"samples":1e99})"})
    EXPECT_EQ(ask("PATCH", "/v1/jobs/1", body).status, 400U) << body;
}

TEST_F(ApiTest, WithoutRoomJobsAndUploadsAreRefusedWith507AndAllElseIsAnswered) {
  coordinator.add(1, "rendering");
  coordinator.full = "the server keeps 5 TiB";
  const std::string blob = "/v1/blobs/" + std::string(64, 'a');
  for (const HttpResponse& response :
       {ask("POST", "/v1/jobs", spec_text), ask("PUT", blob, "bytes")}) {
    EXPECT_EQ(response.status, 507U);
    EXPECT_EQ(json(response)["title"], "Insufficient Storage");
    EXPECT_THAT(json(response)["detail"].get<std::string>(), HasSubstr("5 TiB"));
    EXPECT_THAT(json(response)["detail"].get<std::string>(), HasSubstr("tessera purge"));
  }
  EXPECT_THAT(coordinator.calls, IsEmpty());
  EXPECT_EQ(ask("GET", "/v1/jobs/1").status, 200U);
}

TEST_F(ApiTest, AJobsFramesAreShownAsTheirRanges) {
  JobSpec spec = FakeCoordinator::spec();
  spec.frames = frames_from_text("1,5,10-20x5");
  coordinator.add(1, "rendering", spec);
  const Json frames = json(ask("GET", "/v1/jobs/1"))["frames"];
  EXPECT_EQ(frames["first"], 1);
  EXPECT_EQ(frames["last"], 20);
  EXPECT_EQ(frames["count"], 5);
  EXPECT_TRUE(frames["step"].is_null());
  EXPECT_EQ(frames["ranges"].size(), spec.frames.ranges.size());
}

TEST_F(ApiTest, MetricsSayWhatIsKept) {
  coordinator.stored.journal = 11;
  coordinator.stored.checkpoints = 22;
  coordinator.stored.blobs = 33;
  coordinator.stored.films = 44;
  coordinator.stored.films_most = 55;
  const std::string text = this->text(ask("GET", "/metrics"));
  EXPECT_THAT(text, HasSubstr("tessera_storage_bytes{kind=\"journal\"} 11\n"));
  EXPECT_THAT(text, HasSubstr("tessera_storage_bytes{kind=\"checkpoints\"} 22\n"));
  EXPECT_THAT(text, HasSubstr("tessera_storage_bytes{kind=\"blobs\"} 33\n"));
  EXPECT_THAT(text, HasSubstr("tessera_film_memory_bytes 44\n"));
  EXPECT_THAT(text, HasSubstr("tessera_film_memory_limit_bytes 55\n"));
}

}  // namespace
}  // namespace tessera::server
