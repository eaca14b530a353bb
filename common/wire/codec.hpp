#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/wire/messages.hpp"

/// Messages to and from the JSON headers of frames. Pure.
namespace tessera::wire {

/// Most leases that one message may name; longer lists go in several messages.
constexpr std::size_t leases_per_message = 4096;

/// A message without its body, as it stands in a frame.
struct EncodedMessage {
  std::uint16_t type = 0;
  std::string header;  ///< JSON
};

/// Texts for people are cut to what the limits allow; bytes in them that are not UTF-8 are
/// replaced. Throws Error{too_large} if a list of leases is longer than leases_per_message.
EncodedMessage encode(const Message& message);

/// Reads a frame's header. Unknown keys are ignored (but within a job's spec they are errors: to
/// render without knowing what a key means would give other bits). Throws Error{bad_input} that
/// names the key: lacking, of the wrong type, out of range; or the message type, if it is unknown.
Message decode(std::uint16_t type, std::string_view header);

/// True if messages of this type bring a body.
bool has_body(std::uint16_t type);
/// "hello", "welcome", …; empty for an unknown type.
std::string_view name_of(std::uint16_t type);
/// How many message types there are; they are numbered from 1.
std::uint16_t message_types();

}  // namespace tessera::wire
