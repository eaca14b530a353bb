#pragma once
#include "common/net/http_client.hpp"

namespace tessera::net {

/// Throws the Error that a response with a status of 400 or above stands for. For this folder
/// alone.
[[noreturn]] void throw_problem(const HttpResponse& response);

}  // namespace tessera::net
