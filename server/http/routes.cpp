#include "server/http/routes.hpp"

#include <array>

#include "server/http/handlers.hpp"

namespace tessera::server {

namespace {

constexpr std::array exposure = {
    Parameter{"exposure", "stops by which the picture is made brighter; 0 unless given"}};
constexpr std::array since = {
    Parameter{"since", "the version that the caller has; 0, for all tiles, unless given"}};
constexpr std::array token = {Parameter{"token", "the server's token, exchanged for a cookie"}};
constexpr std::array idempotency = {
    Parameter{"Idempotency-Key",
              "a name for this request, in quotes (draft-ietf-httpapi-idempotency-key-header): a "
              "repetition under it gives the first one's job, also after a restart"}};
constexpr std::array upload = {
    Parameter{"Upload-Offset", "where in the blob the body begins, in bytes; 0 unless given"},
    Parameter{"Upload-Length", "bytes of the whole blob; unless given it ends with the body"}};
constexpr std::array range = {
    Parameter{"Range", "bytes=FIRST-LAST: a part of the blob (RFC 9110, 14.2)"}};
constexpr Refusal no_room{"507", "The server's disk is full, or holds as much as it may"};
constexpr std::array submit_refusals = {
    Refusal{"409", "The bundle, or a blob that it names, is lacking"},
    Refusal{"413", "The film of a frame is more than the server keeps in memory"},
    Refusal{"422", "The Idempotency-Key was used for a job that was asked for in other words"},
    no_room};
constexpr std::array upload_refusals = {
    Refusal{"409", "The bytes begin beyond those that are kept"},
    Refusal{"413", "The blob is larger than a blob may be"},
    Refusal{"422", "The bytes have another digest"}, no_room};
constexpr std::array job_refusals = {Refusal{"409", "The job's state does not allow it"}, no_room};
constexpr std::array change_refusals = {
    Refusal{"409", "The job's state does not allow it, or what it has is damaged"},
    Refusal{"503", "What the job has is still being written or read through: try again"}, no_room};
constexpr std::array full_disk = {no_room};
constexpr std::array release_refusals = {Refusal{"404", "No worker of that name is quarantined"},
                                         no_room};
constexpr std::array purge = {
    Parameter{"purge",
              "true: the job has ended, and nothing of it is to be left; false, unless "
              "given: it is under way, and is to be cancelled"}};

constexpr std::string_view json = "application/json";
constexpr Role user = Role::user;
constexpr Role blob_reader = Role::blob_reader;

constexpr std::array table = {
    Route{"POST", "/v1/blobs/missing", blobs_missing, user, json,
          "Which of these blobs are lacking"},
    Route{"GET",
          "/v1/blobs/{sha256}",
          get_blob,
          blob_reader,
          "application/octet-stream",
          "A blob, or a range of it",
          {},
          range},
    Route{"HEAD", "/v1/blobs/{sha256}", head_blob, blob_reader, "application/octet-stream",
          "Whether a blob is there; if not, Upload-Offset says how much of a broken-off upload is"},
    Route{"PUT",
          "/v1/blobs/{sha256}",
          put_blob,
          user,
          json,
          "Store a blob, whole or from an offset; what has come of one that breaks off is kept",
          {},
          upload,
          upload_refusals},
    Route{"POST",
          "/v1/jobs",
          submit_job,
          user,
          json,
          "Submit a job",
          {},
          idempotency,
          submit_refusals},
    Route{"GET", "/v1/jobs", list_jobs, user, json, "All jobs"},
    Route{"GET", "/v1/jobs/{id}", get_job, user, json,
          "One job: state, progress, time to finish, shares"},
    Route{"PATCH",
          "/v1/jobs/{id}",
          change_job,
          user,
          json,
          "Pause, resume, change priority, most of workers or focus region, or go on to more "
          "samples",
          {},
          {},
          change_refusals},
    Route{"DELETE",
          "/v1/jobs/{id}",
          cancel_job,
          user,
          json,
          "Cancel a job; or remove one that has ended, with its pictures",
          purge,
          {},
          job_refusals},
    Route{"GET", "/v1/jobs/{id}/failures", list_failures, user, json,
          "The newest attempts at its tasks that gave no result, with their reasons and logs"},
    Route{"GET", "/v1/jobs/{id}/frames/{frame}/image.exr", frame_exr, user, "image/x-exr",
          "The picture so far, all channels"},
    Route{"GET", "/v1/jobs/{id}/frames/{frame}/image.png", frame_png, user, "image/png",
          "The picture so far, for screens", exposure},
    Route{"GET", "/v1/jobs/{id}/frames/{frame}/tiles", frame_tiles, user,
          "application/octet-stream", "The tiles that changed after a version", since},
    Route{"GET", "/v1/jobs/{id}/events", job_events, user, "text/event-stream",
          "Events of one job"},
    Route{"GET", "/v1/events", all_events, user, "text/event-stream",
          "Events of all jobs and workers"},
    Route{"GET", "/v1/workers", list_workers, user, json,
          "All workers that are connected, and the names that are quarantined"},
    Route{"PATCH",
          "/v1/workers/{id}",
          change_worker,
          user,
          json,
          "Drain a worker, or quarantine or release all of its name",
          {},
          {},
          full_disk},
    Route{"GET", "/v1/quarantines", list_quarantines, user, json,
          "Names whose workers are granted nothing, with who said so, when and why"},
    Route{"PUT",
          "/v1/quarantines/{name}",
          put_quarantine,
          user,
          json,
          "Grant workers of this name nothing until they are released, those too that come later",
          {},
          {},
          full_disk},
    Route{"DELETE",
          "/v1/quarantines/{name}",
          delete_quarantine,
          user,
          json,
          "Release the workers of this name",
          {},
          {},
          release_refusals},
    Route{"GET", "/metrics", show_metrics, user, "text/plain",
          "Counts and gauges, as Prometheus reads them"},
    Route{"GET", "/healthz", show_health, user, json, "The process answers"},
    Route{"GET", "/readyz", show_ready, user, json, "The coordinator takes jobs and grants leases"},
    Route{"GET", "/openapi.json", show_openapi, user, json, "This description"},
    Route{"GET", "/", show_page, user, "text/html", "The page for people", token},
    Route{"GET", "/web/{file}", show_page, user, "text/plain", "A file of the page"},
};

/// True if the segments fit the pattern; `values` then are those of its {…}.
bool fits(std::string_view pattern, const std::vector<std::string>& segments,
          std::vector<std::string>& values) {
  values.clear();
  std::size_t used = 0;
  pattern.remove_prefix(1);
  while (!pattern.empty()) {
    const std::size_t end = std::min(pattern.find('/'), pattern.size());
    const std::string_view part = pattern.substr(0, end);
    pattern.remove_prefix(std::min(end + 1, pattern.size()));
    if (used == segments.size()) return false;
    const std::string& segment = segments[used++];
    if (part.front() == '{')
      values.push_back(segment);
    else if (part != segment)
      return false;
  }
  return used == segments.size();
}

}  // namespace

std::span<const Route> routes() { return table; }

RouteMatch find_route(std::string_view method, const Target& target) {
  RouteMatch match;
  const Route* get = nullptr;
  std::vector<std::string> values;
  std::string_view found;  // a literal segment stands before a {…} in the table, and hides it
  for (const Route& route : table) {
    if (!fits(route.pattern, target.segments, values)) continue;
    if (!found.empty() && route.pattern != found) continue;
    found = route.pattern;
    match.allow += (match.allow.empty() ? "" : ", ") + std::string(route.method);
    if (route.method == "GET") get = &route;
    if (route.method != method || match.route != nullptr) continue;
    match.route = &route;
    match.values = values;
  }
  if (match.route == nullptr && method == "HEAD" && get != nullptr) {
    match.route = get;
    fits(get->pattern, target.segments, match.values);
  }
  if (get != nullptr && match.allow.find("HEAD") == std::string::npos) match.allow += ", HEAD";
  return match;
}

}  // namespace tessera::server
