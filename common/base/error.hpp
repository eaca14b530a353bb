#pragma once
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

namespace tessera {

/// Where in something a person or a peer wrote. Any part may be absent (empty, or 0 for line and
/// column).
struct Place {
  std::string file;
  int line = 0;     ///< 1-based
  int column = 0;   ///< 1-based, in bytes
  std::string key;  ///< path of keys, e.g. "shapes[3].material"

  /// "file:line:column: key", as much of it as there is.
  [[nodiscard]] std::string text() const;
};

/// What kind of thing went wrong; decides a program's exit code and an HTTP answer's status.
enum class ErrorKind {
  bad_input,    ///< something that a person or peer wrote: exit 2, HTTP 400
  not_found,    ///< names something that is not there: exit 1, HTTP 404
  refused,      ///< not allowed: exit 4, HTTP 401 or 403
  conflict,     ///< does not fit the present state: exit 1, HTTP 409
  too_large,    ///< beyond a limit: exit 2, HTTP 413
  unreachable,  ///< a server that does not answer: exit 3
  no_room,      ///< a disk is full, or as full as it may be: exit 1, HTTP 507
  failed,       ///< the thing was tried and failed (disk, device): exit 1, HTTP 500
};

/// What the system says of a file: not_found, no_room or failed.
ErrorKind kind_of(const std::error_code& error);

/// The one exception type that crosses folders. what() is a whole sentence that a person can act
/// on: the place, what was wrong, what was expected.
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, std::string message, Place place = {});

  [[nodiscard]] ErrorKind kind() const { return kind_; }
  [[nodiscard]] const Place& place() const { return place_; }
  /// The message without the place.
  [[nodiscard]] const std::string& message() const { return message_; }

 private:
  ErrorKind kind_;
  Place place_;
  std::string message_;
};

/// The exit code that scripts rely on: 1 failed, 2 bad input, 3 server not reached, 4 refused.
int exit_code(ErrorKind kind);

}  // namespace tessera
