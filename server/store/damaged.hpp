#pragma once
#include <string>

#include "common/base/error.hpp"

namespace tessera::server {

/// What was read is not what was written: its CRC differs, or it is cut off. No later attempt finds
/// it otherwise. Where the disk could not be read it is an Error that is none of these: the next
/// attempt may go well.
class DamagedError : public Error {
 public:
  explicit DamagedError(const std::string& message) : Error(ErrorKind::failed, message) {}
};

}  // namespace tessera::server
