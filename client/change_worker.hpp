#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "client/server.hpp"
#include "client/settings.hpp"
#include "common/base/json.hpp"

/// Workers that a person keeps from work, or gives work again.
namespace tessera::client {

/// The number of the worker that is meant by its number or its name, from what GET /v1/workers
/// answers. Throws Error{not_found} that names the nearest, or, where several have the name,
/// Error{conflict} with their numbers.
std::uint64_t find_worker(const Json& answer, const std::string& text);

/// The name of the worker that is meant so: of one that is connected or, if `absent_too`, of those
/// that are quarantined. Throws Error{not_found} that names the nearest.
std::string name_of_worker(const Json& answer, const std::string& text, bool absent_too);

/// Does `change` to each name, as change_workers does.
int change_names(const Settings& settings, const std::vector<std::string>& workers, bool absent_too,
                 const std::function<Json(Server&, const std::string& name)>& change);

/// PATCHes each of them; what goes wrong with one is said, and the others are changed all the same.
int change_workers(const Settings& settings, const std::vector<std::string>& workers,
                   const Json& body);

}  // namespace tessera::client
