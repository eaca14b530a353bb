#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/json.hpp"

/// What `--vary` says. Pure.
namespace tessera::client {

/// A parameter, and the values that it takes one after the other.
struct Vary {
  std::string parameter;     ///< a job's, or a path of keys in the scene
  std::vector<Json> values;  ///< at least one, no two the same
};

/// From "NAME=VALUE,VALUE,…". A value is a JSON value or a bare word; commas within brackets or
/// quotes belong to the value, and a number may begin with its point. Throws Error{bad_input}.
Vary vary_from(std::string_view text);

/// A value as labels and file names show it: text as it is, anything else as JSON without blanks.
std::string value_text(const Json& value);

}  // namespace tessera::client
