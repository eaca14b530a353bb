// What is not about one job: probes, description, metrics, the page, tokens.
#include "server/http/api.hpp"

#include "api_fixture.hpp"

namespace tessera::server {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

const std::string bundle(64, 'a');

TEST_F(ApiTest, TheProbesAndTheDescriptionAnswer) {
  EXPECT_EQ(json(ask("GET", "/healthz"))["status"], "ok");
  EXPECT_EQ(json(ask("GET", "/readyz"))["epoch"], 3);
  EXPECT_TRUE(json(ask("GET", "/openapi.json"))["paths"].contains("/v1/jobs/{id}"));
}

TEST_F(ApiTest, MetricsCountJobsByStateAndTheRequestsSoFar) {
  coordinator.add(1);
  coordinator.add(2);
  coordinator.add(3, "failed");
  const HttpResponse response = ask("GET", "/metrics");
  const std::string body = text(response);
  EXPECT_THAT(std::string(response.field("Content-Type").value_or("")), HasSubstr("version=0.0.4"));
  EXPECT_THAT(body, HasSubstr("tessera_jobs{state=\"rendering\"} 2\n"));
  EXPECT_THAT(body, HasSubstr("tessera_jobs{state=\"failed\"} 1\n"));
  EXPECT_THAT(body, HasSubstr("tessera_http_requests_total 1\n"));
  EXPECT_THAT(body, HasSubstr("\ntessera_process_cpu_seconds_total "));
}

TEST_F(ApiTest, MetricsCountWhatBecameOfResultsLeasesAndWorkers) {
  coordinator.counted.results_accepted = 11;
  coordinator.counted.results_duplicate = 12;
  coordinator.counted.results_stale = 13;
  coordinator.counted.rejected = {1, 2, 4, 8, 16};
  coordinator.counted.leases_granted = 14;
  coordinator.counted.leases_revoked = 15;
  coordinator.counted.leases_expired = 16;
  coordinator.counted.workers_joined = 17;
  coordinator.counted.workers_lost = 18;
  const std::string body = text(ask("GET", "/metrics"));
  for (const char* line :
       {"# TYPE tessera_results_total counter", "tessera_results_total{outcome=\"accepted\"} 11",
        "tessera_results_total{outcome=\"duplicate\"} 12",
        "tessera_results_total{outcome=\"stale\"} 13",
        "tessera_results_total{outcome=\"rejected\"} 31",
        "tessera_results_rejected_total{reason=\"plan\"} 1",
        "tessera_results_rejected_total{reason=\"task\"} 2",
        "tessera_results_rejected_total{reason=\"lease\"} 4",
        "tessera_results_rejected_total{reason=\"statistics\"} 8",
        "tessera_results_rejected_total{reason=\"tile\"} 16", "tessera_leases_granted_total 14",
        "tessera_leases_revoked_total 15", "tessera_leases_expired_total 16",
        "tessera_workers_joined_total 17", "tessera_workers_lost_total 18"})
    EXPECT_THAT(body, HasSubstr(std::string(line) + "\n"));
}

TEST_F(ApiTest, ThePageComesWithAPolicyThatLetsNothingElseIn) {
  const HttpResponse page = ask("GET", "/");
  EXPECT_EQ(page.status, 200U);
  EXPECT_EQ(page.field("Content-Type"), "text/html; charset=utf-8");
  EXPECT_THAT(std::string(page.field("Content-Security-Policy").value_or("")),
              HasSubstr("default-src 'none'"));
  EXPECT_THAT(text(page), HasSubstr("<title>Tessera"));
  EXPECT_EQ(
      ask("GET", "/", {}, {{"if-none-match", std::string(page.field("ETag").value_or(""))}}).status,
      304U);
  EXPECT_EQ(ask("GET", "/web/app.js").field("Content-Type"), "text/javascript; charset=utf-8");
  EXPECT_EQ(ask("GET", "/web/nothing.js").status, 404U);
  EXPECT_EQ(ask("GET", "/web/..%2f..%2fetc%2fpasswd").status, 404U);
}

class GuardedApiTest : public ApiTest {
 protected:
  GuardedApiTest() {
    ApiSettings settings = loopback();
    settings.access.token = "sesame";
    settings.access.blob_token = "reader";
    guarded = std::make_unique<Api>(coordinator, blobs, files, settings);
  }
  HttpResponse ask_guarded(const std::string& method, const std::string& target,
                           HttpFields fields = {}) {
    TextBody body("{}");
    HttpRequest request;
    request.method = method;
    request.target = target;
    request.fields = std::move(fields);
    request.fields.emplace_back("host", "localhost:8420");
    request.body = &body;
    return finish(context, guarded->handle(request));
  }
  std::unique_ptr<Api> guarded;
};

TEST_F(GuardedApiTest, EveryRouteAsksForTheToken) {
  for (const char* target :
       {"/v1/jobs", "/metrics", "/healthz", "/openapi.json", "/web/app.js", "/nowhere", "/"})
    EXPECT_EQ(ask_guarded("GET", target).status, 401U) << target;
  EXPECT_EQ(ask_guarded("GET", "/v1/jobs", {{"authorization", "Bearer sesame"}}).status, 200U);
}

TEST_F(GuardedApiTest, TheBlobTokenReadsBlobsAlone) {
  const HttpFields reader = {{"authorization", "Bearer reader"}};
  EXPECT_EQ(ask_guarded("GET", "/v1/blobs/" + bundle, reader).status, 404U)
      << "let in, and not there";
  EXPECT_EQ(ask_guarded("PUT", "/v1/blobs/" + bundle, reader).status, 403U);
  EXPECT_EQ(ask_guarded("GET", "/v1/jobs", reader).status, 403U);
}

TEST_F(GuardedApiTest, ThePageIsOpenedByItsTokenOnce) {
  const HttpResponse asked = ask_guarded("GET", "/");
  EXPECT_EQ(asked.status, 401U);
  EXPECT_THAT(text(asked), HasSubstr("name=\"token\""));
  EXPECT_EQ(ask_guarded("GET", "/?token=wrong").status, 401U);
  const HttpResponse entry = ask_guarded("GET", "/?token=sesame");
  EXPECT_EQ(entry.status, 303U);
  const std::string cookie(entry.field("Set-Cookie").value_or(""));
  EXPECT_EQ(ask_guarded("GET", "/", {{"cookie", cookie.substr(0, cookie.find(';'))}}).status, 200U);
  EXPECT_EQ(ask_guarded("GET", "/v1/jobs?token=sesame").status, 401U)
      << "a token in an URL opens the page alone";
}

}  // namespace
}  // namespace tessera::server
