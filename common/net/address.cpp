#include "common/net/address.hpp"

#include <fmt/format.h>

#include <boost/asio/ip/address.hpp>
#include <charconv>

#include "common/base/error.hpp"

namespace tessera::net {

namespace {
[[noreturn]] void bad(std::string_view text, std::string_view found) {
  throw Error(ErrorKind::bad_input,
              fmt::format("expected an address as HOST:PORT or [IPV6]:PORT, found \"{}\": {}",
                          text.substr(0, 256), found));
}

std::uint16_t port_from(std::string_view port, std::string_view whole) {
  std::uint16_t value = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), value);
  if (port.empty() || error != std::errc{} || end != port.data() + port.size())
    bad(whole, "the port is no number from 0 to 65535");
  return value;
}
}  // namespace

std::string Address::text() const {
  return host.find(':') == std::string::npos ? fmt::format("{}:{}", host, port)
                                             : fmt::format("[{}]:{}", host, port);
}

Address parse_address(std::string_view text, std::uint16_t default_port) {
  std::string_view host = text;
  std::uint16_t port = default_port;
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    if (end == std::string_view::npos) bad(text, "the bracket is not closed");
    host = text.substr(1, end - 1);
    const std::string_view rest = text.substr(end + 1);
    if (!rest.empty() && rest[0] != ':') bad(text, "behind the bracket stands no \":\"");
    if (!rest.empty()) port = port_from(rest.substr(1), text);
    boost::system::error_code error;
    boost::asio::ip::make_address_v6(std::string(host), error);
    if (error) bad(text, "within the brackets stands no IPv6 address");
  } else if (const std::size_t colon = text.find(':'); colon != std::string_view::npos) {
    if (text.find(':', colon + 1) != std::string_view::npos)
      bad(text, "an IPv6 address stands in brackets");
    host = text.substr(0, colon);
    port = port_from(text.substr(colon + 1), text);
  }
  if (host.empty() || host.size() > 253) bad(text, "the host has no name, or too long a one");
  for (const char c : host)
    if (c <= ' ' || c == '/' || c == '@' || c == '\x7f')
      bad(text, "the host has characters that no host has");
  return {.host = std::string(host), .port = port};
}

bool is_loopback(std::string_view host) {
  if (host == "localhost") return true;
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(std::string(host), error);
  if (error) return false;
  if (address.is_v6() && address.to_v6().is_v4_mapped())
    return boost::asio::ip::make_address_v4(boost::asio::ip::v4_mapped, address.to_v6())
        .is_loopback();
  return address.is_loopback();
}

}  // namespace tessera::net
