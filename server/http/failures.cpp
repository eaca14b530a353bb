#include <nlohmann/json.hpp>

#include "server/http/handlers.hpp"
#include "server/http/views.hpp"

namespace tessera::server {

HandlerResult list_failures(Call& call) {
  const JobStatus status = job_of(call);
  const JobId id = status.view.id;
  const std::vector<FailureRecord> newest = co_await call.api.coordinator.failures(id);
  Json failures = Json::array();
  for (const FailureRecord& failure : newest)
    failures.push_back(failure_object(failure, status.plan->grid));
  Json body = Json::object();
  body["count"] = status.failures;
  body["failures"] = std::move(failures);
  co_return json_response(body);
}

}  // namespace tessera::server
