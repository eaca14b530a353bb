#include "tests/unit/client/support.hpp"

#include <gtest/gtest.h>

namespace tessera::client {

Error error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "no error";
  return Error(ErrorKind::failed, "none");
}

}  // namespace tessera::client
