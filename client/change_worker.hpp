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

/// Which names of workers that are not connected may be meant.
enum class Absent { quarantined, any };

struct NamedWorker {
  std::string name;
  std::string note;  ///< for the person, if nobody of that name is here or known
};

/// The name of the worker that is meant so: of one that is connected, by its number or name, or of
/// one of `absent`. Throws Error{not_found} that names the nearest; also for a number that no
/// worker has, which is nobody's name.
NamedWorker name_of_worker(const Json& answer, const std::string& text, Absent absent);

/// Does `change` to each name, as change_workers does.
int change_names(const Settings& settings, const std::vector<std::string>& workers, Absent absent,
                 const std::function<Json(Server&, const std::string& name)>& change);

/// PATCHes each of them; what goes wrong with one is said, and the others are changed all the same.
int change_workers(const Settings& settings, const std::vector<std::string>& workers,
                   const Json& body);

}  // namespace tessera::client
