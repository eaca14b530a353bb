#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "server/http/handlers.hpp"
#include "server/http/views.hpp"

namespace tessera::server {

namespace {
WorkerView worker_of(const Call& call) {
  const auto id = job_id_from(call.values.front());  // workers are numbered as jobs are, from 1
  const std::vector<WorkerView> workers = call.api.coordinator.workers();
  const auto found = std::find_if(workers.begin(), workers.end(),
                                  [&](const WorkerView& worker) { return worker.id == id; });
  if (found == workers.end())
    throw Error(ErrorKind::not_found,
                fmt::format("there is no worker \"{}\"", call.values.front().substr(0, 64)),
                {.key = "id"});
  return *found;
}
}  // namespace

HandlerResult list_workers(Call& call) {
  Json workers = Json::array();
  for (const WorkerView& worker : call.api.coordinator.workers())
    workers.push_back(worker_object(worker));
  Json body = Json::object();
  body["workers"] = std::move(workers);
  co_return json_response(body);
}

HandlerResult change_worker(Call& call) {
  const WorkerId id = worker_of(call).id;
  const Json body = co_await json_body(call);
  ObjectReader in(body, "");
  const std::string state = in.text("state");
  const std::string reason = in.text_or("reason", "asked for by a person");
  in.finish();
  const WorkerView worker = worker_of(call);  // it may have gone while the body came
  if (state == "draining") {
    call.api.coordinator.drain_worker(id);
  } else if (state == "quarantined") {
    call.api.coordinator.quarantine_worker(id, reason.substr(0, 1000));
  } else if (state == "idle") {
    if (worker.state == "draining")
      throw Error(ErrorKind::conflict, "a worker that drains leaves: start it again",
                  {.key = "state"});
    call.api.coordinator.release_worker(id);
  } else {
    in.fail("state", unknown_name("state", state, {"draining", "quarantined", "idle"}));
  }
  co_return json_response(worker_object(worker_of(call)));
}

}  // namespace tessera::server
