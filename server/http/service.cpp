#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "common/base/build_info.hpp"
#include "server/http/handlers.hpp"
#include "server/http/metrics.hpp"
#include "server/http/openapi.hpp"
#include "server/http/web_files.hpp"

namespace tessera::server {

namespace {
/// The page takes nothing from elsewhere and speaks to nobody else.
constexpr std::string_view page_policy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
    "connect-src 'self'; "
    "form-action 'self'; base-uri 'none'; frame-ancestors 'none'";

constexpr std::string_view entry_text = R"(<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>Tessera</title>
<h1>Tessera</h1>
<p>{}</p>
<form method="get" action="/"><label>Token <input name="token" type="password" autocomplete="current-password" autofocus></label>
<button>Open</button></form>
</html>
)";
}  // namespace

HandlerResult show_metrics(Call& call) {
  HttpResponse response;
  response.fields = {{"Content-Type", "text/plain; version=0.0.4; charset=utf-8"},
                     {"Cache-Control", "no-store"}};
  response.body = metrics_text(call.api.coordinator.jobs(), call.api.coordinator.workers(),
                               call.api.coordinator.counters(), call.api.coordinator.storage(),
                               call.api.counters, process_usage());
  co_return response;
}

HandlerResult show_health(Call&) {
  Json body = Json::object();
  body["status"] = "ok";
  body["version"] = version();
  body["commit"] = build_commit();
  co_return json_response(body);
}

HandlerResult show_ready(Call& call) {
  if (const std::string trouble = call.api.coordinator.trouble(); !trouble.empty())
    co_return problem(503, "results cannot be kept at present: " + trouble);
  Json body = Json::object();
  body["status"] = "ready";  // the port is opened when the coordinator is
  body["epoch"] = call.api.coordinator.epoch();
  co_return json_response(body);
}

HandlerResult show_openapi(Call&) { co_return json_response(openapi_description(routes())); }

HandlerResult show_page(Call& call) {
  const std::string_view name =
      call.values.empty() ? "index.html" : std::string_view(call.values.front());
  const WebFile* file = find_web_file(name);
  if (file == nullptr)
    co_return problem(404, fmt::format("the page has no file \"{}\"", name.substr(0, 64)));
  HttpResponse response;
  response.fields = {{"Content-Type", std::string(file->type)},
                     {"ETag", file->etag},
                     {"Cache-Control", "no-cache"},
                     {"Content-Security-Policy", std::string(page_policy)}};
  if (none_match_names(call.request, file->etag))
    response.status = 304;
  else
    response.body = file->text;
  co_return response;
}

HttpResponse entry_page(bool wrong_token) {
  HttpResponse response;
  response.status = 401;
  response.fields = {{"Content-Type", "text/html; charset=utf-8"},
                     {"Cache-Control", "no-store"},
                     {"WWW-Authenticate", "Bearer realm=\"tessera\""},
                     {"Content-Security-Policy", std::string(page_policy)}};
  response.body = fmt::format(entry_text, wrong_token ? "That was not this server's token."
                                                      : "This server asks for its token.");
  return response;
}

}  // namespace tessera::server
