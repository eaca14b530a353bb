#include "common/base/error.hpp"

#include <fmt/format.h>

#include <cerrno>

#include "common/base/names.hpp"

namespace tessera {

std::string Place::text() const {
  std::string out = file;
  if (line > 0) out += fmt::format("{}{}", out.empty() ? "line " : ":", line);
  if (column > 0) out += fmt::format(":{}", column);
  if (!key.empty()) out += (out.empty() ? "" : ": ") + key;
  return out;
}

namespace {

/// Messages go into JSON, logs and terminals, and hold words from outside: lines of UTF-8.
std::string legible(std::string_view text) {
  std::string out;
  for (std::size_t end = text.find('\n'); end != std::string_view::npos; end = text.find('\n')) {
    out += excerpt(text.substr(0, end), end) + '\n';
    text.remove_prefix(end + 1);
  }
  return out + excerpt(text, text.size());
}

std::string whole(const std::string& message, const Place& place) {
  const std::string where = place.text();
  return legible(where.empty() ? message : where + ": " + message);
}

}  // namespace

Error::Error(ErrorKind kind, std::string message, Place place)
    : std::runtime_error(whole(message, place)),
      kind_(kind),
      place_(std::move(place)),
      message_(legible(message)) {}

ErrorKind kind_of(const std::error_code& error) {
  if (error == std::errc::no_such_file_or_directory || error == std::errc::not_a_directory)
    return ErrorKind::not_found;
  const bool full = error == std::errc::no_space_on_device ||
                    error == std::error_code(EDQUOT, std::generic_category()) ||
                    error == std::error_code(EDQUOT, std::system_category());
  return full ? ErrorKind::no_room : ErrorKind::failed;
}

int exit_code(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::bad_input:
    case ErrorKind::too_large:
      return 2;
    case ErrorKind::unreachable:
      return 3;
    case ErrorKind::refused:
      return 4;
    case ErrorKind::not_found:
    case ErrorKind::conflict:
    case ErrorKind::no_room:
    case ErrorKind::failed:
      break;
  }
  return 1;
}

}  // namespace tessera
