#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "server/http/message.hpp"

/// Who may ask what. Pure.
namespace tessera::server {

struct AccessSettings {
  std::string token;       ///< every request must show it; empty: none is needed
  std::string blob_token;  ///< opens GET and HEAD of blobs alone; empty: there is none
  std::string public_url;  ///< e.g. "http://farm.example:8420": its host and origin are good ones
                           ///< too; may be empty
  bool loopback = true;    ///< listening on a loopback address: Host is checked
  std::uint16_t port = 0;  ///< listened on
};

/// What a route asks of the one who calls it.
enum class Role {
  user,         ///< the token
  blob_reader,  ///< the token, or the blob token
};

/// Nothing if the request names this server and comes from no other site; else the answer that
/// refuses it: 400, 403, 421.
std::optional<HttpResponse> check_origin(const HttpRequest& request,
                                         const AccessSettings& settings);

/// Nothing if the request shows what `role` needs; else 401 or 403.
std::optional<HttpResponse> check_token(const HttpRequest& request, Role role,
                                        const AccessSettings& settings);

/// For a page opened with ?token=…: sends it to the same path without the token, and sets the
/// cookie. Nothing if `token` is not the right one, or none is needed.
std::optional<HttpResponse> exchange_token(std::string_view token, std::string_view path,
                                           const AccessSettings& settings);

/// The value that the cookie must have: made from the token, but not the token.
std::string cookie_value(std::string_view token);

}  // namespace tessera::server
