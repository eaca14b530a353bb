#pragma once
#include <chrono>
#include <cstdint>

namespace tessera {

using Duration = std::chrono::nanoseconds;
/// A monotonic instant. What decides is given it as `now` and never asks for it.
using Instant = std::chrono::time_point<std::chrono::steady_clock, Duration>;

/// Wall-clock time for people and files, in milliseconds since 1970-01-01 UTC.
using UnixMillis = std::int64_t;

inline UnixMillis unix_millis_now() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

inline double seconds(Duration duration) { return std::chrono::duration<double>(duration).count(); }

}  // namespace tessera
