#include "server/http/access.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "common/base/digest.hpp"
#include "common/base/random.hpp"

namespace tessera::server {

namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

/// "http://host:port" of an URL, in lower case; empty if it is none.
std::string origin_of(std::string_view url) {
  const std::size_t scheme = url.find("://");
  if (scheme == std::string_view::npos) return {};
  return lower(url.substr(0, url.find_first_of("/?#", scheme + 3)));
}

std::string host_of(std::string_view url) {
  const std::string origin = origin_of(url);
  return origin.empty() ? origin : origin.substr(origin.find("://") + 3);
}

/// An address cannot be made to name another host, so every one of 127.0.0.0/8 is good.
bool is_loopback_name(std::string_view name) {
  if (name == "localhost" || name == "[::1]") return true;
  return name.substr(0, 4) == "127." && std::all_of(name.begin(), name.end(), [](char c) {
           return c == '.' || (c >= '0' && c <= '9');
         });
}

bool is_loopback_host(std::string_view host, std::uint16_t port) {
  const std::string suffix = fmt::format(":{}", port);
  if (host.size() > suffix.size() && host.substr(host.size() - suffix.size()) == suffix)
    return is_loopback_name(host.substr(0, host.size() - suffix.size()));
  return port == 80 && is_loopback_name(host);
}

std::string cookie_name(const AccessSettings& settings) {
  // A browser sends cookies to every port of a host: two servers on one machine must not share
  // theirs.
  return fmt::format("tessera_{}", settings.port);
}

std::optional<std::string_view> cookie(const HttpRequest& request, const AccessSettings& settings) {
  const std::string name = cookie_name(settings) + "=";
  for (const auto& [field, value] : request.fields) {
    if (field != "cookie") continue;
    std::string_view rest = value;
    while (!rest.empty()) {
      const std::size_t end = std::min(rest.find(';'), rest.size());
      std::string_view one = rest.substr(0, end);
      rest.remove_prefix(std::min(end + 1, rest.size()));
      while (!one.empty() && one.front() == ' ') one.remove_prefix(1);
      if (one.substr(0, name.size()) == name) return one.substr(name.size());
    }
  }
  return std::nullopt;
}

std::optional<std::string_view> bearer(const HttpRequest& request) {
  const auto shown = request.field("authorization");
  if (!shown || shown->size() < 7 || lower(shown->substr(0, 7)) != "bearer ") return std::nullopt;
  return shown->substr(7);
}

HttpResponse unauthorized(std::string_view detail) {
  HttpResponse response = problem(401, detail);
  response.fields.emplace_back("WWW-Authenticate", "Bearer realm=\"tessera\"");
  return response;
}

/// What browsers say themselves of where a request comes from. To open a page by a link is good
/// from everywhere.
bool from_another_site(const HttpRequest& request) {
  const auto site = request.field("sec-fetch-site");
  if (!site || *site == "same-origin" || *site == "none") return false;
  const bool opened = request.method == "GET" && request.field("sec-fetch-mode") == "navigate" &&
                      request.field("sec-fetch-dest") == "document";
  return !opened;
}

}  // namespace

std::optional<HttpResponse> check_origin(const HttpRequest& request,
                                         const AccessSettings& settings) {
  const auto hosts = std::count_if(request.fields.begin(), request.fields.end(),
                                   [](const auto& field) { return field.first == "host"; });
  if (hosts != 1) return problem(400, fmt::format("expected one Host field, found {}", hosts));
  const std::string host = lower(*request.field("host"));
  const std::string public_host = host_of(settings.public_url);
  const bool is_public = !public_host.empty() && host == public_host;
  if (settings.loopback && !is_public && !is_loopback_host(host, settings.port))
    return problem(
        421,
        fmt::format(
            "this server listens on loopback as 127.0.0.1:{0}, localhost:{0} or [::1]:{0}, not as "
            "\"{1}\"; --public-url names another host that is good",
            settings.port, host.substr(0, 128)));
  if (const auto sent = request.field("origin")) {
    const std::string origin = lower(*sent);
    const bool own = origin == "http://" + host || origin == "https://" + host ||
                     (!settings.public_url.empty() && origin == origin_of(settings.public_url));
    if (!own)
      return problem(
          403, fmt::format("a page from {} may not speak to this server", origin.substr(0, 128)));
  }
  if (from_another_site(request))
    return problem(403, "a page from another site may not speak to this server");
  return std::nullopt;
}

std::optional<HttpResponse> check_token(const HttpRequest& request, Role role,
                                        const AccessSettings& settings) {
  if (settings.token.empty()) return std::nullopt;
  if (const auto shown = bearer(request)) {
    if (equal_secrets(*shown, settings.token)) return std::nullopt;
    if (!settings.blob_token.empty() && equal_secrets(*shown, settings.blob_token)) {
      if (role == Role::blob_reader) return std::nullopt;
      return problem(403, "this token opens blobs for reading alone");
    }
    return unauthorized("the token is not this server's");
  }
  if (const auto shown = cookie(request, settings);
      shown && equal_secrets(*shown, cookie_value(settings.token)))
    return std::nullopt;
  return unauthorized("this server asks for its token, as Authorization: Bearer TOKEN");
}

std::optional<HttpResponse> exchange_token(std::string_view token, std::string_view path,
                                           const AccessSettings& settings) {
  if (settings.token.empty() || !equal_secrets(token, settings.token)) return std::nullopt;
  HttpResponse response;
  response.status = 303;
  response.fields = {
      {"Location", std::string(path)},
      {"Cache-Control", "no-store"},
      {"Set-Cookie", fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict; Max-Age=31536000",
                                 cookie_name(settings), cookie_value(settings.token))}};
  return response;
}

std::string cookie_value(std::string_view token) {
  return digest_of(fmt::format("tessera page {}", token)).hex();
}

}  // namespace tessera::server
