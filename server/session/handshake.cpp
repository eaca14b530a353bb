#include "server/session/handshake.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/names.hpp"
#include "common/net/address.hpp"
#include "common/net/token.hpp"

namespace tessera::server {

namespace {

bool is_identity(std::string_view text) {
  const auto is_hex = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
  };
  return text.size() == 32 && std::all_of(text.begin(), text.end(), is_hex);
}

}  // namespace

std::optional<wire::Refused> check_hello(const wire::Hello& hello, std::string_view token) {
  if (!net::token_admits(token, hello.token))
    return wire::Refused{"token", hello.token.empty()
                                      ? "this coordinator asks for a token, and none was shown"
                                      : "the token is not this coordinator's"};
  if (!is_identity(hello.identity))
    return wire::Refused{"protocol", "identity: expected 32 hexadecimal digits"};
  if (!is_plain_name(hello.name))
    return wire::Refused{"protocol", "name: expected 1 to 128 bytes without control characters"};
  if (hello.threads < 1 || hello.threads > 4096)
    return wire::Refused{"protocol",
                         fmt::format("threads: expected 1 to 4096, found {}", hello.threads)};
  return std::nullopt;
}

wire::Refused refusal_of(const wire::FrameError& error) {
  return {error.problem() == wire::FrameProblem::version ? "version" : "protocol", error.message()};
}

std::string blob_url_for(std::string_view wanted, std::string_view local, std::uint16_t http_port) {
  if (!wanted.empty()) return std::string(wanted);
  net::Address address = net::parse_address(local, 0);
  address.port = http_port;
  return "http://" + address.text();
}

}  // namespace tessera::server
