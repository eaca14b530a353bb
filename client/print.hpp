#pragma once
#include <string>
#include <vector>

#include "common/base/json.hpp"

namespace tessera::client {

/// One line of JSON on standard output, there at once for whoever reads it.
void print_json(const Json& json);

/// What a person should know of a scene, each on a line of standard error.
void print_warnings(const std::vector<std::string>& warnings);

}  // namespace tessera::client
