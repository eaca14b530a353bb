#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "client/settings.hpp"
#include "common/base/json.hpp"

/// Workers that a person keeps from work, or gives work again.
namespace tessera::client {

/// The number of the worker that is meant by its number or its name, from what GET /v1/workers
/// answers. Throws Error{not_found} that names the nearest, or, where several have the name,
/// Error{conflict} with their numbers.
std::uint64_t find_worker(const Json& answer, const std::string& text);

/// PATCHes each of them; what goes wrong with one is said, and the others are changed all the same.
int change_workers(const Settings& settings, const std::vector<std::string>& workers,
                   const Json& body);

}  // namespace tessera::client
