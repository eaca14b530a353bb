#pragma once
#include "common/base/json.hpp"

namespace tessera::client {

/// One line of JSON on standard output, there at once for whoever reads it.
void print_json(const Json& json);

}  // namespace tessera::client
