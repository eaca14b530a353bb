#pragma once
#include <boost/asio/awaitable.hpp>
#include <cstddef>

#include "common/base/json.hpp"
#include "common/job/task.hpp"
#include "server/coordinator/coordinator.hpp"
#include "server/http/message.hpp"
#include "server/http/routes.hpp"

/// Every handler of the table, by file, and what they share.
namespace tessera::server {

using HandlerResult = boost::asio::awaitable<HttpResponse>;

// blobs.cpp
HandlerResult blobs_missing(Call& call);
HandlerResult get_blob(Call& call);
HandlerResult head_blob(Call& call);
// put_blob.cpp
HandlerResult put_blob(Call& call);
// jobs.cpp
HandlerResult submit_job(Call& call);
HandlerResult list_jobs(Call& call);
HandlerResult get_job(Call& call);
HandlerResult change_job(Call& call);
HandlerResult cancel_job(Call& call);
// failures.cpp
HandlerResult list_failures(Call& call);
// frames.cpp
HandlerResult frame_exr(Call& call);
HandlerResult frame_png(Call& call);
HandlerResult frame_tiles(Call& call);
// events.cpp
HandlerResult job_events(Call& call);
HandlerResult all_events(Call& call);
// workers.cpp
HandlerResult list_workers(Call& call);
HandlerResult change_worker(Call& call);
HandlerResult list_quarantines(Call& call);
HandlerResult put_quarantine(Call& call);
HandlerResult delete_quarantine(Call& call);
// service.cpp
HandlerResult show_metrics(Call& call);
HandlerResult show_health(Call& call);
HandlerResult show_ready(Call& call);
HandlerResult show_openapi(Call& call);
HandlerResult show_page(Call& call);
/// What a browser without the token sees: a form that asks for it. 401.
HttpResponse entry_page(bool wrong_token);

// ---- shared (api.cpp) ----
/// The body as JSON. Throws Error{bad_input} or Error{too_large}.
boost::asio::awaitable<Json> json_body(Call& call);
/// The job that the path names by its first value. Throws Error{not_found}.
JobStatus job_of(const Call& call);
/// True if If-None-Match names `etag` (quoted) or is *.
bool none_match_names(const HttpRequest& request, std::string_view etag);

}  // namespace tessera::server
