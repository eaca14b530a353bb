#include "client/change_worker.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/print.hpp"
#include "client/server.hpp"
#include "common/base/error.hpp"
#include "common/base/names.hpp"

namespace tessera::client {

std::uint64_t find_worker(const Json& answer, const std::string& text) {
  std::vector<std::uint64_t> named;
  std::vector<std::string> names;
  ObjectReader in(answer, "");
  const Json& workers = in.required("workers");
  try {
    for (const Json& worker : workers) {
      const auto id = worker.at("id").get<std::uint64_t>();
      names.push_back(worker.at("name").get<std::string>());
      if (std::to_string(id) == text) return id;
      if (names.back() == text) named.push_back(id);
    }
  } catch (const Json::exception& odd) {
    throw Error(ErrorKind::failed,
                fmt::format("the server's list of workers cannot be read: {}", odd.what()));
  }
  if (named.size() == 1) return named.front();
  if (named.size() > 1)
    throw Error(ErrorKind::conflict,
                fmt::format("{} workers are called \"{}\": say which by its number, one of {}",
                            named.size(), text, fmt::join(named, ", ")));
  if (names.empty())
    throw Error(ErrorKind::not_found,
                fmt::format("there is no worker \"{}\": none is connected", excerpt(text)));
  const std::vector<std::string_view> known(names.begin(), names.end());
  throw Error(ErrorKind::not_found, unknown_name("worker", text, known));
}

namespace {

bool is_number(const std::string& text) {
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

NamedWorker name_of_worker(const Json& answer, const std::string& text, Absent absent) {
  std::vector<std::string> names;
  std::string numbered;
  ObjectReader in(answer, "");
  try {
    for (const Json& worker : in.required("workers")) {
      names.push_back(worker.at("name").get<std::string>());
      if (std::to_string(worker.at("id").get<std::uint64_t>()) == text) numbered = names.back();
    }
    for (const Json& one : in.required("quarantines"))
      names.push_back(one.at("name").get<std::string>());
  } catch (const Json::exception& odd) {
    throw Error(ErrorKind::failed,
                fmt::format("the server's list of workers cannot be read: {}", odd.what()));
  }
  if (!numbered.empty()) return {numbered, ""};
  if (std::find(names.begin(), names.end(), text) != names.end()) return {text, ""};
  const std::vector<std::string_view> known(names.begin(), names.end());
  const std::string unknown =
      names.empty() ? fmt::format("there is no worker \"{}\": none is connected or quarantined",
                                  excerpt(text))
                    : unknown_name("worker", text, known);
  if (absent == Absent::any && !is_number(text))
    return {text, unknown + "; whoever comes under this name is meant"};
  throw Error(ErrorKind::not_found, unknown);
}

namespace {

/// One after another; what goes wrong with one is said.
int change_each_worker(
    const Settings& settings, const std::vector<std::string>& workers,
    const std::function<Json(Server&, const Json&, const std::string&)>& change) {
  Server server(settings);
  const Json connected = server.get("/v1/workers");
  int code = 0;
  for (const std::string& worker : workers) {
    try {
      const Json answer = change(server, connected, worker);
      if (settings.json) print_json(answer);
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::unreachable) throw;
      fmt::print(stderr, "tessera: worker {}: {}\n", excerpt(worker), error.what());
      if (code == 0) code = exit_code(error.kind());
    }
  }
  return code;
}

}  // namespace

int change_names(const Settings& settings, const std::vector<std::string>& workers, Absent absent,
                 const std::function<Json(Server&, const std::string& name)>& change) {
  return change_each_worker(settings, workers,
                            [&](Server& server, const Json& connected, const std::string& worker) {
                              const NamedWorker meant = name_of_worker(connected, worker, absent);
                              Json changed = change(server, meant.name);
                              if (!meant.note.empty())
                                fmt::print(stderr, "tessera: {}\n", meant.note);
                              return changed;
                            });
}

int change_workers(const Settings& settings, const std::vector<std::string>& workers,
                   const Json& body) {
  return change_each_worker(
      settings, workers, [&](Server& server, const Json& connected, const std::string& worker) {
        return server.patch(fmt::format("/v1/workers/{}", find_worker(connected, worker)), body);
      });
}

}  // namespace tessera::client
