#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

#include "common/base/clock.hpp"

/// Sizes and times as people write them on a command line. Pure, but for what the machine has.
namespace tessera::server {

/// "512M", "2GiB", "1.5T", "4096": bytes; K, M, G and T are powers of 1024, with or without "B" or
/// "iB". Throws Error{bad_input} that names `flag`.
std::uint64_t size_from(std::string_view text, const char* flag);

/// "90s", "30m", "12h", "7d", "2w"; nullopt for "forever". Throws Error{bad_input} that names
/// `flag`.
std::optional<Duration> time_from(std::string_view text, const char* flag);

/// Of the machine, or what its control group may use if that is less, bytes.
std::uint64_t machine_memory();

}  // namespace tessera::server
