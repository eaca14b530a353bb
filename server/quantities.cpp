#include "server/quantities.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string>

#include "common/base/error.hpp"

namespace tessera::server {

namespace {

/// The number at the front, and what follows it.
std::optional<double> take_number(std::string_view& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !std::isfinite(value) || value < 0) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

[[noreturn]] void bad(const char* flag, const char* expected, std::string_view found) {
  throw Error(ErrorKind::bad_input,
              fmt::format("expected {}, found \"{}\"", expected, found.substr(0, 64)),
              {.file = {}, .key = flag});
}

}  // namespace

std::uint64_t size_from(std::string_view text, const char* flag) {
  constexpr const char* expected = "a size such as 512M, 2GiB or 1.5T";
  constexpr std::string_view units = "KMGT";
  constexpr double most = 9e18;
  std::string_view rest = text;
  const auto number = take_number(rest);
  if (!number) bad(flag, expected, text);
  double bytes = *number;
  if (!rest.empty()) {
    const std::size_t unit = units.find(rest.front());
    if (unit == std::string_view::npos) bad(flag, expected, text);
    rest.remove_prefix(1);
    if (!rest.empty() && rest != "B" && rest != "iB") bad(flag, expected, text);
    bytes *= std::pow(1024.0, static_cast<double>(unit + 1));
  }
  if (bytes < 1 || bytes > most) bad(flag, expected, text);
  return static_cast<std::uint64_t>(bytes);
}

std::optional<Duration> time_from(std::string_view text, const char* flag) {
  constexpr const char* expected = "a time such as 90s, 30m, 12h, 7d or 2w, or forever";
  constexpr double most = 1e9;  // seconds: 30 years
  if (text == "forever") return std::nullopt;
  std::string_view rest = text;
  const auto number = take_number(rest);
  if (!number || rest.size() != 1) bad(flag, expected, text);
  double unit = 0;
  switch (rest.front()) {
    case 's':
      unit = 1;
      break;
    case 'm':
      unit = 60;
      break;
    case 'h':
      unit = 3600;
      break;
    case 'd':
      unit = 86400;
      break;
    case 'w':
      unit = 7 * 86400.0;
      break;
    default:
      bad(flag, expected, text);
  }
  if (*number * unit > most) bad(flag, expected, text);
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(*number * unit));
}

std::uint64_t machine_memory() {
  const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
  std::uint64_t bytes = pages > 0 && page > 0
                            ? static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page)
                            : std::uint64_t{4} << 30;
  for (const char* file :
       {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    std::ifstream in(file);
    std::uint64_t limit = 0;
    if (in >> limit && limit > 0) bytes = std::min(bytes, limit);
  }
  return bytes;
}

}  // namespace tessera::server
