#include "client/change_worker.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

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

int change_workers(const Settings& settings, const std::vector<std::string>& workers,
                   const Json& body) {
  Server server(settings);
  const Json connected = server.get("/v1/workers");
  int code = 0;
  for (const std::string& worker : workers) {
    try {
      const Json answer =
          server.patch(fmt::format("/v1/workers/{}", find_worker(connected, worker)), body);
      if (settings.json) print_json(answer);
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::unreachable) throw;
      fmt::print(stderr, "tessera: worker {}: {}\n", excerpt(worker), error.what());
      if (code == 0) code = exit_code(error.kind());
    }
  }
  return code;
}

}  // namespace tessera::client
