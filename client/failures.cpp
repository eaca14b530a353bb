#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/commands.hpp"
#include "client/print.hpp"
#include "client/server.hpp"
#include "client/table.hpp"
#include "common/base/error.hpp"

namespace tessera::client {

namespace {

std::string text_or(const Json& value, const char* otherwise) {
  return value.is_string() ? value.get<std::string>() : otherwise;
}

/// "frame 1 tile 12 pass 3", or what failed before there was a task.
std::string task_text(const Json& failure) {
  if (failure.at("tile").is_null()) return "preparation";
  return fmt::format("frame {} tile {} pass {}", failure.at("frame").get<std::int64_t>(),
                     failure.at("tile").get<std::int64_t>(),
                     failure.at("pass").get<std::int64_t>());
}

/// What does not fit into a table: the worker's log, indented.
void print_log(const Json& failure) {
  const std::string log = text_or(failure.at("log"), "");
  if (log.empty()) return;
  fmt::print("\n{} of {} on {}, its log:\n", failure.at("outcome").get<std::string>(),
             task_text(failure), failure.at("worker").get<std::string>());
  for (std::size_t at = 0; at < log.size();) {
    const std::size_t end = std::min(log.find('\n', at), log.size());
    fmt::print("    {}\n", log.substr(at, end - at));
    at = end + 1;
  }
}

}  // namespace

int failures(const Settings& settings, JobId job) {
  Server server(settings);
  const Json answer = server.get(fmt::format("/v1/jobs/{}/failures", job));
  if (settings.json) {
    print_json(answer);
    return 0;
  }
  Table table{{{"ENDED"}, {"OUTCOME"}, {"WORKER"}, {"TASK"}, {"REASON"}}, {}};
  ObjectReader in(answer, "");
  const Json& newest = in.required("failures");
  try {
    for (const Json& failure : newest)
      table.rows.push_back({text_or(failure.at("ended"), ""),
                            failure.at("outcome").get<std::string>(),
                            failure.at("worker").get<std::string>(), task_text(failure),
                            failure.at("reason").get<std::string>()});
    fmt::print("{}", text_of(table));
    for (const Json& failure : newest) print_log(failure);
    const auto count = answer.at("count").get<std::uint64_t>();
    if (count > newest.size())
      fmt::print(stderr, "tessera: the newest {} of {}\n", newest.size(), count);
  } catch (const Json::exception& odd) {
    throw Error(ErrorKind::failed,
                fmt::format("the server's list of failures cannot be read: {}", odd.what()));
  }
  return 0;
}

}  // namespace tessera::client
