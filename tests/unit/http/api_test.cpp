#include "server/http/api.hpp"

#include "api_fixture.hpp"
#include "common/base/limits.hpp"

namespace tessera::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string bundle(64, 'a');

std::string spec_text(const std::string& name, const std::string& more = {}) {
  return R"({"name":")" + name + R"(","bundle":")" + bundle +
         R"(","render":{"width":32,"height":16})" + more + "}";
}

TEST_F(ApiTest, ASubmittedJobIsCreatedAndShown) {
  const HttpResponse response = ask("POST", "/v1/jobs", spec_text("cornell"));
  EXPECT_EQ(response.status, 201U);
  EXPECT_EQ(response.field("Location"), "/v1/jobs/1");
  EXPECT_THAT(coordinator.calls, ElementsAre("submit cornell"));
  const Json job = json(response);
  EXPECT_EQ(job["id"], 1);
  EXPECT_EQ(job["state"], "queued");
  EXPECT_EQ(job["spec"]["bundle"], bundle);
}

TEST_F(ApiTest, AJobThatIsPostedTwiceUnderOneKeyIsOneJob) {
  const HttpFields key{{"idempotency-key", "\"4f1c\""}};
  const Json first = json(ask("POST", "/v1/jobs", spec_text("cornell"), key));
  const HttpResponse again = ask("POST", "/v1/jobs", spec_text("cornell"), key);
  EXPECT_EQ(again.status, 201U);
  EXPECT_EQ(json(again)["id"], first["id"]);
  EXPECT_EQ(coordinator.known.size(), 1U);
  const HttpResponse other = ask("POST", "/v1/jobs", spec_text("sponza"), key);
  EXPECT_EQ(other.status, 422U);
  EXPECT_THAT(json(other)["detail"].get<std::string>(), HasSubstr("job 1"));
  for (const std::string bad : {"", "\"\"", "a\tb"})
    EXPECT_EQ(ask("POST", "/v1/jobs", spec_text("x"), {{"idempotency-key", bad}}).status, 400U);
}

TEST_F(ApiTest, FailedAttemptsAreListedWithTheirPlaceReasonAndLog) {
  coordinator.add(3).failures = 205;
  FailureRecord failure;
  failure.number = 205;
  failure.task = TaskId{1, 1, 0};
  failure.worker = 4;
  failure.worker_name = "render-1";
  failure.outcome = "failed";
  failure.ended = 1'700'000'000'000;
  failure.reason = "no memory";
  failure.log = "a\nb\n";
  FailureRecord preparation;
  preparation.outcome = "lost";
  coordinator.failed_attempts = {failure, preparation};
  const Json answer = json(ask("GET", "/v1/jobs/3/failures"));
  EXPECT_EQ(answer["count"], 205);
  const Json& first = answer["failures"][0];
  EXPECT_EQ(first["tile"], 1);
  EXPECT_EQ(first["window"], (Json{{"x", 16}, {"y", 0}, {"width", 16}, {"height", 16}}));
  EXPECT_EQ(first["worker"], "render-1");
  EXPECT_EQ(first["started"], nullptr);
  EXPECT_EQ(first["ended"], "2023-11-14T22:13:20.000Z");
  EXPECT_EQ(first["reason"], "no memory");
  EXPECT_EQ(first["log"], "a\nb\n");
  EXPECT_EQ(answer["failures"][1]["tile"], nullptr);
  EXPECT_EQ(json(ask("GET", "/v1/jobs/3"))["failures"], 205);
  EXPECT_EQ(ask("GET", "/v1/jobs/4/failures").status, 404U);
}

TEST_F(ApiTest, ReadyzSaysWhyResultsCannotBeKept) {
  EXPECT_EQ(ask("GET", "/readyz").status, 200U);
  coordinator.disk_trouble = "No space left on device";
  const HttpResponse response = ask("GET", "/readyz");
  EXPECT_EQ(response.status, 503U);
  EXPECT_THAT(json(response)["detail"].get<std::string>(), HasSubstr("No space left"));
}

TEST_F(ApiTest, AnUnknownKeyIsRefusedWithItsPlaceAndTheNearestName) {
  const HttpResponse response = ask("POST", "/v1/jobs", spec_text("cornell", R"(,"prority":3)"));
  EXPECT_EQ(response.status, 400U);
  EXPECT_EQ(response.field("Content-Type"), "application/problem+json");
  const Json problem = json(response);
  EXPECT_EQ(problem["title"], "Bad Request");
  EXPECT_EQ(problem["status"], 400);
  EXPECT_EQ(problem["place"]["key"], "prority");
  EXPECT_THAT(problem["detail"].get<std::string>(), HasSubstr("\"priority\""));
  EXPECT_THAT(coordinator.calls, IsEmpty());
}

TEST_F(ApiTest, ADoubledKeyIsRefusedWithLineAndColumn) {
  const Json problem = json(ask("POST", "/v1/jobs", "{\"name\": \"a\",\n \"name\": \"b\"}"));
  EXPECT_EQ(problem["status"], 400);
  EXPECT_EQ(problem["place"]["line"], 2);
  EXPECT_GT(problem["place"]["column"], 1);
  EXPECT_THAT(problem["detail"].get<std::string>(), HasSubstr("twice"));
}

TEST_F(ApiTest, BodiesThatAreNoGoodAreRefused) {
  EXPECT_EQ(ask("POST", "/v1/jobs", "").status, 400U);
  EXPECT_EQ(ask("POST", "/v1/jobs", "{").status, 400U);
  EXPECT_EQ(ask("POST", "/v1/jobs", std::string(200'000, '[')).status, 400U);
  EXPECT_EQ(ask("POST", "/v1/jobs", std::string(limits::http_json_body + 1, ' ')).status, 413U);
  EXPECT_THAT(coordinator.calls, IsEmpty());
}

TEST_F(ApiTest, ABodyThatIsSaidToBeTooLargeIsNotRead) {
  TextBody body(std::string(limits::http_json_body + 1, ' '));
  EXPECT_EQ(ask_with("POST", "/v1/jobs", body).status, 413U);
  EXPECT_EQ(body.bytes_read(), 0U);
}

TEST_F(ApiTest, AFilmTooLargeIsRefusedByItsKey) {
  const std::string huge = R"({"name":"x","bundle":")" + bundle +
                           R"(","render":{"width":1000000,"height":1000000,"samples":1000000000}})";
  const Json problem = json(ask("POST", "/v1/jobs", huge));
  EXPECT_EQ(problem["status"], 400);
  EXPECT_EQ(problem["place"]["key"], "render.width");
}

TEST_F(ApiTest, AConflictOfTheCoordinatorsIs409) {
  const HttpResponse response = ask("POST", "/v1/jobs", spec_text("lacking"));
  EXPECT_EQ(response.status, 409U);
  EXPECT_EQ(json(response)["place"]["key"], "bundle");
}

TEST_F(ApiTest, AMistakeOfOursIs500AndTellsNothing) {
  const HttpResponse response = ask("POST", "/v1/jobs", spec_text("broken"));
  EXPECT_EQ(response.status, 500U);
  EXPECT_EQ(text(response).find("secret"), std::string::npos);
}

TEST_F(ApiTest, JobsAreListedAndAnUnknownOneIs404) {
  coordinator.add(1);
  coordinator.add(2, "done");
  const Json jobs = json(ask("GET", "/v1/jobs"))["jobs"];
  ASSERT_EQ(jobs.size(), 2U);
  EXPECT_EQ(jobs[1]["state"], "done");
  EXPECT_EQ(ask("GET", "/v1/jobs/3").status, 404U);
  EXPECT_EQ(ask("GET", "/v1/jobs/one").status, 404U);
  coordinator.frame_samples = 48;
  const Json pictures = json(ask("GET", "/v1/jobs/1"))["pictures"];
  EXPECT_EQ(pictures, Json::parse(R"([{"frame":1,"version":7,"samples":48}])"));
}

TEST_F(ApiTest, AJobIsPausedResumedAndGivenAPriority) {
  coordinator.add(1);
  EXPECT_EQ(json(ask("PATCH", "/v1/jobs/1", R"({"state":"paused","priority":-5})"))["state"],
            "paused");
  EXPECT_THAT(coordinator.calls, ElementsAre("priority -5", "paused"));
  EXPECT_EQ(ask("PATCH", "/v1/jobs/1", R"({"state":"paused"})").status, 200U);
  const Json job = json(ask("PATCH", "/v1/jobs/1", R"({"state":"rendering"})"));
  EXPECT_EQ(job["state"], "rendering");
  EXPECT_EQ(job["priority"], -5);
}

TEST_F(ApiTest, AJobThatIsResumedWhileTheBodyComesIsPausedAllTheSame) {
  class Body : public TextBody {
   public:
    explicit Body(JobStatus& job) : TextBody(R"({"state":"paused"})"), job_(job) {}
    boost::asio::awaitable<std::size_t> read(std::span<std::byte> buffer) override {
      job_.view.state = "rendering";
      return TextBody::read(buffer);
    }

   private:
    JobStatus& job_;
  };
  coordinator.add(1, "paused");
  Body body(coordinator.known.at(1));
  const HttpResponse response = ask_with("PATCH", "/v1/jobs/1", body);
  EXPECT_EQ(response.status, 200U);
  EXPECT_EQ(json(response)["state"], "paused");
}

TEST_F(ApiTest, AFocusIsSetMovedAndTakenAwayAndSoIsTheMostOfWorkers) {
  coordinator.add(1);
  const Json focus = {{"x", 1}, {"y", 2}, {"width", 3}, {"height", 4}};
  Json job = json(ask("PATCH", "/v1/jobs/1", Json{{"focus", focus}, {"max_workers", 3}}.dump()));
  EXPECT_EQ(job["focus"], focus);
  EXPECT_EQ(job["max_workers"], 3);
  job = json(ask("PATCH", "/v1/jobs/1", R"({"priority":2})"));
  EXPECT_EQ(job["focus"], focus) << "what is not named stays";
  EXPECT_EQ(job["max_workers"], 3);
  job = json(ask("PATCH", "/v1/jobs/1", R"({"focus":null})"));
  EXPECT_TRUE(job["focus"].is_null());
}

TEST_F(ApiTest, AChangeThatIsWrongInOnePartChangesNothing) {
  coordinator.add(1);
  for (const char* body : {R"({"priority":5,"state":"done"})", R"({"priority":5,"sample":9})",
                           R"({"priority":101})", R"({"max_workers":-1})", R"({"focus":{"x":1}})",
                           R"({"focus":{"x":0,"y":0,"width":99999,"height":1}})", "{}", "[]"})
    EXPECT_EQ(ask("PATCH", "/v1/jobs/1", body).status, 400U) << body;
  EXPECT_THAT(coordinator.calls, IsEmpty());
}

TEST_F(ApiTest, AJobIsCancelledOnceItIsDoneItCannotBe) {
  coordinator.add(1);
  coordinator.add(2, "done");
  EXPECT_EQ(json(ask("DELETE", "/v1/jobs/1"))["state"], "cancelled");
  EXPECT_EQ(ask("DELETE", "/v1/jobs/2").status, 409U);
  EXPECT_EQ(ask("DELETE", "/v1/jobs/9").status, 404U);
}

TEST_F(ApiTest, PicturesComeWithTheirVersionAndAreNotSentTwice) {
  coordinator.add(1);
  const HttpResponse first = ask("GET", "/v1/jobs/1/frames/1/image.exr");
  EXPECT_EQ(first.status, 200U);
  EXPECT_EQ(text(first), "exr of 1 frame 1");
  EXPECT_EQ(first.field("Content-Type"), "image/x-exr");
  EXPECT_EQ(first.field("Tessera-Version"), "7");
  const std::string etag(first.field("ETag").value_or(""));
  const HttpResponse again =
      ask("GET", "/v1/jobs/1/frames/1/image.exr", {}, {{"if-none-match", "\"x\", W/" + etag}});
  EXPECT_EQ(again.status, 304U);
  EXPECT_EQ(again.field("ETag"), etag);
  EXPECT_EQ(coordinator.calls.size(), 1U) << "nothing was encoded for the second";
  coordinator.present_version = 8;
  EXPECT_EQ(ask("GET", "/v1/jobs/1/frames/1/image.exr", {}, {{"if-none-match", etag}}).status,
            200U);
}

TEST_F(ApiTest, ExposureAndSinceAreReadAndWrongOnesRefused) {
  coordinator.add(1);
  EXPECT_EQ(text(ask("GET", "/v1/jobs/1/frames/1/image.png?exposure=-1.5")),
            "png of 1 frame 1 -1.500000");
  EXPECT_EQ(text(ask("GET", "/v1/jobs/1/frames/1/tiles?since=12")), "tiles of 1 frame 1 since 12");
  for (const char* query :
       {"image.png?exposure=bright", "image.png?exposure=nan", "image.png?exposure=1000",
        "image.png?exposre=1", "image.exr?exposure=1", "tiles?since=-1", "tiles?since=1x"})
    EXPECT_EQ(ask("GET", std::string("/v1/jobs/1/frames/1/") + query).status, 400U) << query;
}

TEST_F(ApiTest, AFrameThatTheJobDoesNotHaveIs404) {
  coordinator.add(1);
  for (const char* frame : {"2", "0", "-1", "x", "1x", "99999999999"})
    EXPECT_EQ(ask("GET", std::string("/v1/jobs/1/frames/") + frame + "/image.png").status, 404U)
        << frame;
}

TEST_F(ApiTest, AWorkerIsQuarantinedAndReleasedButNotOnceItDrains) {
  WorkerView worker;
  worker.id = 4;
  worker.info.name = "node-4";
  worker.state = "rendering";
  coordinator.connected.push_back(worker);
  const auto set = [&](const char* body) { return ask("PATCH", "/v1/workers/4", body); };
  EXPECT_EQ(json(set(R"({"state":"quarantined","reason":"its fan is broken"})"))["state"],
            "quarantined");
  EXPECT_EQ(json(set(R"({"state":"idle"})"))["state"], "idle");
  EXPECT_THAT(coordinator.calls,
              ElementsAre("quarantine node-4: its fan is broken", "release node-4"));
  EXPECT_EQ(set(R"({"state":"draining"})").status, 200U);
  EXPECT_EQ(set(R"({"state":"idle"})").status, 409U);
}

TEST_F(ApiTest, WorkersAreListedWithoutTheirIdentityAndDrained) {
  WorkerView worker;
  worker.id = 4;
  worker.info.name = "node-4";
  worker.info.identity = "abcdef";
  worker.info.threads = 8;
  worker.state = "rendering";
  coordinator.connected.push_back(worker);
  const HttpResponse list = ask("GET", "/v1/workers");
  EXPECT_EQ(json(list)["workers"][0]["name"], "node-4");
  EXPECT_EQ(text(list).find("abcdef"), std::string::npos);
  EXPECT_EQ(json(ask("PATCH", "/v1/workers/4", R"({"state":"draining"})"))["state"], "draining");
  EXPECT_THAT(coordinator.calls, ElementsAre("drain 4"));
  EXPECT_EQ(ask("PATCH", "/v1/workers/4", R"({"state":"asleep"})").status, 400U);
  EXPECT_EQ(ask("PATCH", "/v1/workers/5", R"({"state":"draining"})").status, 404U);
}

TEST_F(ApiTest, APathThatIsNotThereIs404AndAMethodThatIsNot405) {
  EXPECT_EQ(ask("GET", "/v2/jobs").status, 404U);
  const HttpResponse response = ask("PUT", "/v1/jobs");
  EXPECT_EQ(response.status, 405U);
  EXPECT_EQ(response.field("Allow"), "POST, GET, HEAD");
}

TEST_F(ApiTest, AForeignOriginOrHostReachesNoHandler) {
  coordinator.add(1);
  const HttpFields foreign = {{"origin", "https://evil.example"}};
  EXPECT_EQ(ask("DELETE", "/v1/jobs/1", {}, foreign).status, 403U);
  EXPECT_EQ(ask("GET", "/v1/jobs", {}, foreign).status, 403U);
  EXPECT_EQ(ask("POST", "/v1/jobs", spec_text("x"), {{"host", "evil.example:8420"}}).status, 421U);
  EXPECT_THAT(coordinator.calls, IsEmpty());
}

}  // namespace
}  // namespace tessera::server
