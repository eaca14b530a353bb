#include "common/net/http_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <string>

#include "common/base/error.hpp"
#include "common/base/json.hpp"

namespace tessera::net {

namespace {
ErrorKind kind_of(int status) {
  switch (status) {
    case 401:
    case 403:
      return ErrorKind::refused;
    case 404:
      return ErrorKind::not_found;
    case 409:
    case 412:
      return ErrorKind::conflict;
    case 413:
      return ErrorKind::too_large;
    case 400:
    case 422:
      return ErrorKind::bad_input;
    case 507:
      return ErrorKind::no_room;
    default:
      return ErrorKind::failed;
  }
}

/// The detail of a problem (RFC 9457), or what there is instead.
std::string problem_text(const HttpResponse& response) {
  try {
    const Json json = parse_json(response.body, "problem");
    for (const char* key : {"detail", "title"})
      if (const auto found = json.find(key);
          json.is_object() && found != json.end() && found->is_string())
        return found->get<std::string>();
  } catch (const Error&) {  // no problem details: the status has to do
  }
  return fmt::format("the server answered with status {}", response.status);
}

/// The place that a problem names, of which the server's own files are no concern of ours.
Place problem_place(const HttpResponse& response) {
  try {
    const Json json = parse_json(response.body, "problem");
    if (!json.is_object()) return {};
    const auto place = json.find("place");
    if (place == json.end() || !place->is_object()) return {};
    if (const auto key = place->find("key"); key != place->end() && key->is_string())
      return {.key = key->get<std::string>()};
  } catch (const Error&) {  // as above
  }
  return {};
}

}  // namespace

void throw_problem(const HttpResponse& response) {
  throw Error(kind_of(response.status), problem_text(response), problem_place(response));
}

std::string HttpResponse::header(std::string_view name) const {
  const auto lower = [](char c) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  };
  for (const auto& [key, value] : headers)
    if (std::equal(key.begin(), key.end(), name.begin(), name.end(),
                   [&](char a, char b) { return lower(a) == lower(b); }))
      return value;
  return {};
}

std::string url_encoded(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '-' || c == '.' || c == '_' || c == '~';
    out += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return out;
}

}  // namespace tessera::net
