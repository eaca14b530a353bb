#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "common/base/clock.hpp"
#include "server/coordinator/coordinator.hpp"

/// How much may be kept, and for how long. Pure.
namespace tessera::server {

/// Why new jobs, or an upload of `more` bytes, are refused; empty: they are not. `reserve`: bytes
/// of the file system that are left to what is here.
std::string refusal_of(const StorageUse& use, std::uint64_t reserve, std::uint64_t more = 0);

/// The bytes to be left of a file system of this size: `most`, but no more than a twentieth of it.
std::uint64_t reserve_of(std::uint64_t file_system, std::uint64_t most);

/// True if a job that ended at `finished` is to be forgotten now.
bool has_expired(UnixMillis finished, UnixMillis now, const std::optional<Duration>& keep);

/// "1.50 GiB", "812 bytes".
std::string bytes_text(std::uint64_t bytes);

}  // namespace tessera::server
