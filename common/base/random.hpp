#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace tessera {

/// `bytes` bytes from the operating system's generator as lower-case hexadecimal digits: tokens and
/// ids. Never for samples.
std::string random_hex(std::size_t bytes);

/// Compares in time that depends on the lengths alone: for secrets.
bool equal_secrets(std::string_view a, std::string_view b);

}  // namespace tessera
