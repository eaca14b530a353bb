#include "server/http/api.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/error.hpp>
#include <boost/system/system_error.hpp>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/log.hpp"
#include "common/base/names.hpp"
#include "server/http/handlers.hpp"

namespace tessera::server {

namespace {

unsigned status_of(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::bad_input:
      return 400;
    case ErrorKind::not_found:
      return 404;
    case ErrorKind::refused:
      return 403;
    case ErrorKind::conflict:
      return 409;
    case ErrorKind::too_large:
      return 413;
    case ErrorKind::unreachable:
      return 503;
    case ErrorKind::no_room:
      return 507;
    case ErrorKind::failed:
      break;
  }
  return 500;
}

/// What can be done about it is no different whatever it was that found no room.
constexpr std::string_view make_room =
    "; make room on the server's disk (tessera purge removes jobs that have ended, with their "
    "pictures), then try again";

HttpResponse problem_of(const Error& error) {
  const unsigned status = status_of(error.kind());
  std::string detail = error.message();
  if (error.kind() == ErrorKind::no_room) detail += make_room;
  Json body = {{"title", reason_phrase(status)}, {"status", status}, {"detail", detail}};
  const Place& place = error.place();
  Json where = Json::object();
  if (!place.file.empty()) where["file"] = place.file;
  if (place.line > 0) where["line"] = place.line;
  if (place.column > 0) where["column"] = place.column;
  if (!place.key.empty()) where["key"] = place.key;
  if (!where.empty()) body["place"] = std::move(where);
  HttpResponse response = json_response(body, status);
  response.fields.front().second = "application/problem+json";
  return response;
}

void check_query(const Route& route, const Target& target) {
  std::vector<std::string_view> known;
  for (const Parameter& parameter : route.query) known.push_back(parameter.name);
  for (const auto& [key, value] : target.query)
    if (std::find(known.begin(), known.end(), key) == known.end())
      throw Error(ErrorKind::bad_input, unknown_name("query parameter", key, known), {.key = key});
}

/// The path alone: a query may hold a token.
std::string_view loggable(const HttpRequest& request) {
  return std::string_view(request.target).substr(0, request.target.find('?'));
}

/// A mistake of ours: the log has what happened, the peer only that it did.
HttpResponse mistake(const HttpRequest& request, std::string_view what) {
  log::error("{} {}: {}", request.method, loggable(request), what);
  return problem(500, "the server met an error of its own; its log says which");
}

/// What every answer tells a browser: nobody else may frame, embed, sniff or be told of it.
void add_common_fields(HttpResponse& response) {
  response.fields.emplace_back("X-Content-Type-Options", "nosniff");
  response.fields.emplace_back("Cross-Origin-Resource-Policy", "same-origin");
  response.fields.emplace_back("Referrer-Policy", "no-referrer");
  if (!response.field("Content-Security-Policy"))
    response.fields.emplace_back("Content-Security-Policy",
                                 "default-src 'none'; frame-ancestors 'none'");
}

}  // namespace

Api::Api(Coordinator& coordinator, assets::BlobStore& blobs, boost::asio::thread_pool& files,
         ApiSettings settings)
    : context_{coordinator, blobs, files, std::move(settings), {}} {}

boost::asio::awaitable<HttpResponse> Api::handle(HttpRequest& request) {
  ++context_.counters.requests;
  HttpResponse response;
  try {
    response = co_await dispatch(request);
  } catch (const Error& error) {
    response = problem_of(error);
    if (response.status == 500 || response.status == 507)
      log::error("{} {}: {}", request.method, loggable(request), error.what());
  } catch (const boost::system::system_error& error) {
    if (error.code() == boost::asio::error::operation_aborted) throw;  // the listener stops
    response = mistake(request, error.what());
  } catch (const std::exception& error) {
    response = mistake(request, error.what());
  }
  add_common_fields(response);
  co_return response;
}

boost::asio::awaitable<HttpResponse> Api::dispatch(HttpRequest& request) {
  const AccessSettings& access = context_.settings.access;
  if (auto refusal = check_origin(request, access)) co_return std::move(*refusal);
  Target target = parse_target(request.target);
  const RouteMatch match = find_route(request.method, target);
  const auto token = match.route != nullptr && !match.route->query.empty()
                         ? target.parameter("token")
                         : std::nullopt;
  if (token)
    if (auto entry = exchange_token(*token, target.path(), access)) co_return std::move(*entry);
  const Role role = match.route == nullptr ? Role::user : match.route->role;
  if (auto refusal = check_token(request, role, access)) {
    if (match.route != nullptr && match.route->answers == "text/html")
      co_return entry_page(token.has_value());
    co_return std::move(*refusal);
  }
  if (match.route == nullptr) {
    if (match.allow.empty())
      co_return problem(404, fmt::format("there is no {}", target.path().substr(0, 256)));
    HttpResponse response =
        problem(405, fmt::format("{} takes {}, not {}", target.path().substr(0, 256), match.allow,
                                 request.method.substr(0, 32)));
    response.fields.emplace_back("Allow", match.allow);
    co_return response;
  }
  check_query(*match.route, target);
  Call call{context_, request, std::move(target), match.values};
  co_return co_await match.route->handler(call);
}

boost::asio::awaitable<Json> json_body(Call& call) {
  BodyReader* body = call.request.body;
  const auto too_large = [] {
    return Error(ErrorKind::too_large,
                 fmt::format("the body has more than {} bytes", limits::http_json_body));
  };
  std::string text;
  if (body != nullptr) {
    if (body->length().value_or(0) > limits::http_json_body) throw too_large();
    std::vector<std::byte> buffer(16 * limits::KiB);
    for (;;) {
      const std::size_t size = co_await body->read(buffer);
      if (size == 0) break;
      if (text.size() + size > limits::http_json_body) throw too_large();
      text.append(reinterpret_cast<const char*>(buffer.data()), size);
    }
  }
  if (text.empty()) throw Error(ErrorKind::bad_input, "expected a JSON body, found none");
  co_return parse_json(text, "body");
}

JobStatus job_of(const Call& call) {
  const auto id = job_id_from(call.values.front());
  auto status = id ? call.api.coordinator.job(*id) : std::nullopt;
  if (!status)
    throw Error(ErrorKind::not_found,
                fmt::format("there is no job \"{}\"", call.values.front().substr(0, 64)),
                {.key = "id"});
  return std::move(*status);
}

bool none_match_names(const HttpRequest& request, std::string_view etag) {
  const auto sent = request.field("if-none-match");
  if (!sent) return false;
  if (*sent == "*") return true;
  std::string_view rest = *sent;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(','), rest.size());
    std::string_view one = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    while (!one.empty() && one.front() == ' ') one.remove_prefix(1);
    while (!one.empty() && one.back() == ' ') one.remove_suffix(1);
    if (one.substr(0, 2) == "W/") one.remove_prefix(2);
    if (one == etag) return true;
  }
  return false;
}

}  // namespace tessera::server
