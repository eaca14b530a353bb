#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "common/wire/framing.hpp"
#include "common/wire/messages.hpp"

/// What a stranger must show before it is a worker. Pure.
namespace tessera::server {

/// Nothing if the hello can be taken: the token (compared in constant time) before anything else,
/// then an identity of 32 hexadecimal digits, a plain name, 1 to 4096 threads.
std::optional<wire::Refused> check_hello(const wire::Hello& hello, std::string_view token);

/// The last word to a peer that does not speak this protocol: "version" for another version of it,
/// else "protocol".
wire::Refused refusal_of(const wire::FrameError& error);

/// What workers are given: `wanted`, or "http://" with the host of `local` ("host:port", as
/// dialled) and the HTTP port.
std::string blob_url_for(std::string_view wanted, std::string_view local, std::uint16_t http_port);

}  // namespace tessera::server
