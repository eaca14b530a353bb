#pragma once
#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <string_view>

/// Logging for all three programs: one line an event on standard error, with time and level. spdlog
/// stands behind it.
namespace tessera::log {

enum class Level { debug, info, warn, error };

/// The least level that is written. The default is info. Not to be called while other threads log.
void set_level(Level level);
/// From "debug", "info", "warn", "error"; throws Error{bad_input} that names the nearest.
Level level_from(std::string_view name);

/// Keeps the last `lines` lines that are written, for recent(). Not to be called while other
/// threads log.
void keep_recent(std::size_t lines);
/// What keep_recent() kept, oldest first, each ended by a newline.
std::string recent();

void write(Level level, std::string_view line);

template <class... Args>
void debug(fmt::format_string<Args...> format, Args&&... args) {
  write(Level::debug, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void info(fmt::format_string<Args...> format, Args&&... args) {
  write(Level::info, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void warn(fmt::format_string<Args...> format, Args&&... args) {
  write(Level::warn, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void error(fmt::format_string<Args...> format, Args&&... args) {
  write(Level::error, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace tessera::log
