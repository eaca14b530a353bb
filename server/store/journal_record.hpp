#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/store/records.hpp"

/// One result as bytes, little-endian:
///   u32 length of the payload · u32 CRC-32C of the payload · payload:
///   u64 job · 32 bytes plan · i32 frame · u32 tile · u32 pass · u64 epoch · u64 lease number · i64
///   samples · i64 rays · i64 rejected · f64 seconds · f64 CPU seconds · u8 length of the identity
///   · the identity · the EXR
namespace tessera::server {

constexpr std::size_t record_prefix = 8;

/// All of the record but the EXR, with the CRC over both. Throws Error{failed} if the identity is
/// too long, Error{too_large} if the EXR is beyond limits::wire_body.
std::vector<std::byte> record_head(const ResultInfo& info, std::span<const std::byte> exr);

/// From a whole record, prefix included; throws Error{failed} that says what is wrong.
StoredResult parse_record(std::span<const std::byte> bytes);

}  // namespace tessera::server
