#include "server/http/message.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace tessera::server {

namespace {
std::optional<std::string_view> first_of(const HttpFields& fields, std::string_view name) {
  const auto found = std::find_if(fields.begin(), fields.end(),
                                  [&](const auto& field) { return field.first == name; });
  if (found == fields.end()) return std::nullopt;
  return found->second;
}

struct LengthOf {
  std::optional<std::uint64_t> operator()(const std::string& text) const { return text.size(); }
  std::optional<std::uint64_t> operator()(std::string_view text) const { return text.size(); }
  std::optional<std::uint64_t> operator()(const SharedBytes& bytes) const {
    return bytes ? bytes->size() : 0;
  }
  std::optional<std::uint64_t> operator()(const FileSlice& slice) const { return slice.length; }
  std::optional<std::uint64_t> operator()(const std::shared_ptr<TextStream>&) const { return {}; }
};
}  // namespace

std::optional<std::string_view> HttpRequest::field(std::string_view name) const {
  return first_of(fields, name);
}

std::optional<std::string_view> HttpResponse::field(std::string_view name) const {
  return first_of(fields, name);
}

std::optional<std::uint64_t> HttpResponse::length() const { return std::visit(LengthOf{}, body); }

HttpResponse json_response(const Json& json, unsigned status) {
  HttpResponse response;
  response.status = status;
  response.fields = {{"Content-Type", "application/json"}, {"Cache-Control", "no-store"}};
  response.body = json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  return response;
}

HttpResponse problem(unsigned status, std::string_view detail) {
  const Json body = {{"title", reason_phrase(status)}, {"status", status}, {"detail", detail}};
  HttpResponse response = json_response(body, status);
  response.fields.front().second = "application/problem+json";
  return response;
}

std::string_view reason_phrase(unsigned status) {
  switch (status) {
    case 200:
      return "OK";
    case 201:
      return "Created";
    case 202:
      return "Accepted";
    case 204:
      return "No Content";
    case 206:
      return "Partial Content";
    case 303:
      return "See Other";
    case 304:
      return "Not Modified";
    case 400:
      return "Bad Request";
    case 401:
      return "Unauthorized";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 409:
      return "Conflict";
    case 411:
      return "Length Required";
    case 413:
      return "Content Too Large";
    case 416:
      return "Range Not Satisfiable";
    case 421:
      return "Misdirected Request";
    case 422:
      return "Unprocessable Content";
    case 431:
      return "Request Header Fields Too Large";
    case 507:
      return "Insufficient Storage";
    case 503:
      return "Service Unavailable";
    default:
      return "Internal Server Error";
  }
}

}  // namespace tessera::server
