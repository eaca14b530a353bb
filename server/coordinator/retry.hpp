#pragma once
#include <algorithm>
#include <chrono>
#include <exception>
#include <string>

#include "common/base/clock.hpp"

/// What the disk refused is tried again, with pauses that double.
namespace tessera::server {

constexpr Duration retry_first = std::chrono::milliseconds(100);
constexpr Duration retry_most = std::chrono::seconds(10);

/// The pause after a pause of `wait`.
constexpr Duration longer(Duration wait) { return std::min(2 * wait, retry_most); }

/// `error` is one of std::exception.
inline std::string message_of(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const std::exception& known) {
    return known.what();
  }
}

}  // namespace tessera::server
