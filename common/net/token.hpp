#pragma once
#include <string>
#include <string_view>

namespace tessera::net {

/// A new token: 256 bits of the system's randomness as hexadecimal digits.
std::string new_token();
/// The token of an `Authorization: Bearer …` header's value; empty if it is none.
std::string_view bearer_token(std::string_view authorization);
/// True if `shown` is the token that is `wanted`, compared in constant time; an empty `wanted` lets
/// everything in.
bool token_admits(std::string_view wanted, std::string_view shown);

}  // namespace tessera::net
