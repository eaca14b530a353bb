#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace tessera::net {

constexpr std::uint16_t default_http_port = 8420;
constexpr std::uint16_t default_worker_port = 8421;

/// Where a server listens: a name or an IP address without brackets, and a port.
struct Address {
  std::string host = "127.0.0.1";
  std::uint16_t port = 0;
  bool operator==(const Address&) const = default;
  /// "host:port", or "[::1]:port".
  [[nodiscard]] std::string text() const;
};

/// Reads "host:port", "[v6]:port", or a host alone, which then has `default_port`. Throws
/// Error{bad_input}.
Address parse_address(std::string_view text, std::uint16_t default_port);

/// True for "localhost", 127.0.0.0/8 and ::1; other names are not looked up.
bool is_loopback(std::string_view host);

}  // namespace tessera::net
