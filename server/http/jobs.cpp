#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"
#include "common/job/job_spec.hpp"
#include "server/http/handlers.hpp"
#include "server/http/views.hpp"

namespace tessera::server {

namespace {

constexpr std::uint32_t pictures_most = 1000;

/// The job with what only a look at one job shows.
Json detailed(const ApiContext& api, const JobStatus& status) {
  Json job = job_object(status);
  job["spec"] = to_json(status.plan->spec);
  Json pictures = Json::array();
  const FrameList& frames = status.plan->spec.frames;
  const std::uint32_t count = std::min(frames.count(), pictures_most);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::int32_t frame = frames.number(i);
    const auto version = api.coordinator.version(status.view.id, frame);
    const auto samples = api.coordinator.samples(status.view.id, frame);
    if (version.value_or(0) > 0)
      pictures.push_back(
          {{"frame", frame}, {"version", *version}, {"samples", samples.value_or(0)}});
  }
  job["pictures"] = std::move(pictures);
  return job;
}

HttpResponse job_response(const Call& call, JobId id) {
  const auto status = call.api.coordinator.job(id);
  if (!status) throw Error(ErrorKind::not_found, fmt::format("job {} is gone", id), {.key = "id"});
  return json_response(detailed(call.api, *status));
}

/// As draft-ietf-httpapi-idempotency-key-header has it, a string in quotes; without them, too.
/// Empty if there is none.
std::string idempotency_key_of(const HttpRequest& request) {
  constexpr std::size_t most = 255;
  auto key = request.field("idempotency-key").value_or(std::string_view());
  const bool given = request.field("idempotency-key").has_value();
  if (key.size() >= 2 && key.front() == '"' && key.back() == '"')
    key = key.substr(1, key.size() - 2);
  const bool plain = std::all_of(
      key.begin(), key.end(), [](char c) { return c >= ' ' && c <= '~' && c != '"' && c != '\\'; });
  if (given && (key.empty() || key.size() > most || !plain))
    throw Error(
        ErrorKind::bad_input,
        fmt::format("Idempotency-Key: expected 1 to {} printable characters of ASCII", most),
        {.key = "Idempotency-Key"});
  return std::string(key);
}

struct Change {
  std::optional<bool> pause;
  JobChange job;
  std::optional<std::int64_t> samples;
};

/// The whole body is checked before any of it is done.
Change change_from(const Json& body) {
  Change change;
  ObjectReader in(body, "");
  if (in.optional("state") != nullptr) {
    const std::string state = in.text("state");
    if (state != "paused" && state != "rendering")
      in.fail("state", unknown_name("state", state, {"paused", "rendering"}));
    change.pause = state == "paused";
  }
  if (in.optional("priority") != nullptr)
    change.job.priority =
        static_cast<int>(in.integer("priority", -limits::priority_max, limits::priority_max));
  if (in.optional("max_workers") != nullptr)
    change.job.max_workers =
        static_cast<int>(in.integer("max_workers", 0, limits::job_workers_max));
  if (const Json* focus = in.optional("focus")) {
    change.job.focus.emplace();  // null takes it away
    if (!focus->is_null()) *change.job.focus = rect_from_json(*focus, in.path_of("focus"));
  }
  if (in.optional("samples") != nullptr)
    change.samples = in.integer("samples", 1, limits::samples_max);
  in.finish();
  if (!change.pause && change.job.empty() && !change.samples)
    throw Error(ErrorKind::bad_input,
                "expected at least one of \"state\", \"priority\", \"max_workers\", \"focus\" and "
                "\"samples\", found none");
  return change;
}

}  // namespace

HandlerResult submit_job(Call& call) {
  const std::string key = idempotency_key_of(call.request);
  const Json body = co_await json_body(call);
  JobSpec spec = job_spec_from_json(body);
  Submitted submitted;
  if (key.empty()) {
    submitted.job = co_await call.api.coordinator.submit(std::move(spec));
  } else {
    submitted = co_await call.api.coordinator.submit_once(std::move(spec), key);
  }
  if (submitted.of_another_request)
    co_return problem(422, fmt::format("the Idempotency-Key was used for job {}, which was asked "
                                       "for in other words",
                                       submitted.job));
  HttpResponse response = job_response(call, submitted.job);
  response.status = 201;
  response.fields.emplace_back("Location", fmt::format("/v1/jobs/{}", submitted.job));
  co_return response;
}

HandlerResult list_jobs(Call& call) {
  Json jobs = Json::array();
  for (const JobStatus& status : call.api.coordinator.jobs()) jobs.push_back(job_object(status));
  Json body = Json::object();
  body["jobs"] = std::move(jobs);
  co_return json_response(body);
}

HandlerResult get_job(Call& call) { co_return json_response(detailed(call.api, job_of(call))); }

HandlerResult change_job(Call& call) {
  const JobId id = job_of(call).view.id;
  const Json body = co_await json_body(call);
  const Change change = change_from(body);
  if (change.samples) co_await call.api.coordinator.extend(id, *change.samples);
  if (!change.job.empty()) co_await call.api.coordinator.change(id, change.job);
  if (change.pause && *change.pause) co_await call.api.coordinator.pause(id);
  if (change.pause && !*change.pause) co_await call.api.coordinator.resume(id);
  co_return job_response(call, id);
}

HandlerResult cancel_job(Call& call) {
  const JobStatus job = job_of(call);
  const std::string_view purge = call.target.parameter("purge").value_or("false");
  if (purge != "true" && purge != "false")
    throw Error(ErrorKind::bad_input,
                fmt::format("expected true or false, found \"{}\"", purge.substr(0, 64)),
                {.key = "purge"});
  if (purge == "true") {
    const Json last = detailed(call.api, job);
    co_await call.api.coordinator.purge(job.view.id);
    co_return json_response(last);
  }
  co_await call.api.coordinator.cancel(job.view.id);
  co_return job_response(call, job.view.id);
}

}  // namespace tessera::server
