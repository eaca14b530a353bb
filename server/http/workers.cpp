#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "server/http/handlers.hpp"
#include "server/http/views.hpp"

namespace tessera::server {

namespace {

constexpr std::size_t reason_most = 1000;
constexpr const char* reason_else = "asked for by a person";

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

/// By name, in the order of names.
const Quarantine* find(const std::vector<Quarantine>& quarantines, const std::string& name) {
  const auto found = std::find_if(quarantines.begin(), quarantines.end(),
                                  [&](const Quarantine& one) { return one.name == name; });
  return found == quarantines.end() ? nullptr : &*found;
}

Json array_of(const std::vector<Quarantine>& quarantines) {
  Json all = Json::array();
  for (const Quarantine& one : quarantines) all.push_back(quarantine_object(one));
  return all;
}

Json object_of(const Call& call, const WorkerView& worker) {
  const std::vector<Quarantine> quarantines = call.api.coordinator.quarantines();
  return worker_object(worker, find(quarantines, worker.info.name));
}

}  // namespace

HandlerResult list_workers(Call& call) {
  const std::vector<Quarantine> quarantines = call.api.coordinator.quarantines();
  Json workers = Json::array();
  for (const WorkerView& worker : call.api.coordinator.workers())
    workers.push_back(worker_object(worker, find(quarantines, worker.info.name)));
  Json body = Json::object();
  body["workers"] = std::move(workers);
  body["quarantines"] = array_of(quarantines);
  co_return json_response(body);
}

HandlerResult change_worker(Call& call) {
  const WorkerId id = worker_of(call).id;
  const Json body = co_await json_body(call);
  ObjectReader in(body, "");
  const std::string state = in.text("state");
  const std::string reason = in.text_or("reason", reason_else);
  in.finish();
  const WorkerView worker = worker_of(call);  // it may have gone while the body came
  if (state == "draining") {
    call.api.coordinator.drain_worker(id);
  } else if (state == "quarantined") {
    co_await call.api.coordinator.quarantine(worker.info.name, reason.substr(0, reason_most));
  } else if (state == "idle") {
    if (worker.state == "draining")
      throw Error(ErrorKind::conflict, "a worker that drains leaves: start it again",
                  {.key = "state"});
    co_await call.api.coordinator.release(worker.info.name);
  } else {
    in.fail("state", unknown_name("state", state, {"draining", "quarantined", "idle"}));
  }
  co_return json_response(object_of(call, worker_of(call)));
}

HandlerResult list_quarantines(Call& call) {
  Json body = Json::object();
  body["quarantines"] = array_of(call.api.coordinator.quarantines());
  co_return json_response(body);
}

HandlerResult put_quarantine(Call& call) {
  const std::string& name = call.values.front();
  const Json body = co_await json_body(call);
  ObjectReader in(body, "");
  const std::string reason = in.text_or("reason", reason_else);
  in.finish();
  const std::vector<Quarantine> before = call.api.coordinator.quarantines();
  const unsigned status = find(before, name) == nullptr ? 201 : 200;
  co_await call.api.coordinator.quarantine(name, reason.substr(0, reason_most));
  const std::vector<Quarantine> after = call.api.coordinator.quarantines();
  const Quarantine* made = find(after, name);
  if (made == nullptr) throw Error(ErrorKind::conflict, "it has been released meanwhile");
  co_return json_response(quarantine_object(*made), status);
}

HandlerResult delete_quarantine(Call& call) {
  const std::string& name = call.values.front();
  const std::vector<Quarantine> before = call.api.coordinator.quarantines();
  const Quarantine* ended = find(before, name);
  if (ended == nullptr) {
    std::vector<std::string_view> names;
    for (const Quarantine& one : before) names.push_back(one.name);
    throw Error(ErrorKind::not_found,
                names.empty()
                    ? fmt::format("no worker \"{}\" is quarantined: none is", name.substr(0, 128))
                    : unknown_name("quarantined worker", name, names),
                {.key = "name"});
  }
  const Json object = quarantine_object(*ended);
  co_await call.api.coordinator.release(name);
  co_return json_response(object);
}

}  // namespace tessera::server
