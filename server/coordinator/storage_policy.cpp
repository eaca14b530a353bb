#include "server/coordinator/storage_policy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace tessera::server {

std::string bytes_text(std::uint64_t bytes) {
  constexpr std::array<std::string_view, 4> units{"KiB", "MiB", "GiB", "TiB"};
  constexpr double step = 1024;
  if (bytes < 1024) return fmt::format("{} bytes", bytes);
  double value = static_cast<double>(bytes) / step;
  std::size_t unit = 0;
  while (value >= step && unit + 1 < units.size()) {
    value /= step;
    ++unit;
  }
  return fmt::format("{:.2f} {}", value, units[unit]);
}

std::string refusal_of(const StorageUse& use, std::uint64_t reserve, std::uint64_t more) {
  if (use.disk_most > 0 && use.on_disk() >= use.disk_most)
    return fmt::format(
        "the server keeps {} and may keep {} (--disk-limit): nothing new is taken, and jobs that "
        "are here go on",
        bytes_text(use.on_disk()), bytes_text(use.disk_most));
  if (use.disk_most > 0 && more > use.disk_most - use.on_disk())
    return fmt::format("the server keeps {} and may keep {} (--disk-limit): {} more are too many",
                       bytes_text(use.on_disk()), bytes_text(use.disk_most), bytes_text(more));
  if (more > 0 && use.disk_free >= reserve && more > use.disk_free - reserve)
    return fmt::format(
        "the server's file system has {} left, of which the last {} are kept for the jobs that are "
        "here: {} more are too many",
        bytes_text(use.disk_free), bytes_text(reserve), bytes_text(more));
  if (use.disk_free < reserve)
    return fmt::format(
        "the server's file system has {} left, and the last {} are kept for the jobs that are "
        "here: nothing new is taken",
        bytes_text(use.disk_free), bytes_text(reserve));
  return {};
}

std::uint64_t reserve_of(std::uint64_t file_system, std::uint64_t most) {
  constexpr std::uint64_t part = 20;
  return std::min(most, file_system / part);
}

bool has_expired(UnixMillis finished, UnixMillis now, const std::optional<Duration>& keep) {
  if (!keep || finished == 0) return false;
  const auto kept = std::chrono::duration_cast<std::chrono::milliseconds>(*keep).count();
  return now - finished >= kept;
}

}  // namespace tessera::server
