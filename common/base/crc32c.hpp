#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace tessera {

/// CRC-32C (Castagnoli; RFC 3720, appendix B.4): the check value of "123456789" is 0xE3069283.
/// To go on where an earlier piece ended, pass that piece's CRC as `before`.
std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before = 0);

}  // namespace tessera
