#include "client/farm.hpp"

#include <fmt/format.h>
#include <sched.h>
#include <stdlib.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "client/interrupt.hpp"
#include "common/base/error.hpp"
#include "common/base/json.hpp"

namespace tessera::client {

namespace fs = std::filesystem;

namespace {

constexpr std::chrono::seconds start_time{30};
constexpr std::chrono::milliseconds end_time{5000};
constexpr std::chrono::milliseconds end_time_interrupted{
    300};  // whoever pressed Ctrl-C does not want to wait

/// A program that lies beside this one.
fs::path beside(const char* name) {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  fs::path program = self.parent_path() / name;
  if (error || !fs::exists(program, error))
    throw Error(ErrorKind::failed,
                fmt::format("render needs the program {} beside this one, at {}; it is not there",
                            name, program.string()));
  return program;
}

fs::path temporary_folder() {
  std::error_code error;
  fs::path root = fs::temp_directory_path(error);
  if (error) root = "/tmp";
  std::string pattern = (root / "tessera-render-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr)
    throw Error(ErrorKind::failed,
                fmt::format("no temporary folder can be made in {}", root.string()));
  return pattern;
}

}  // namespace

ServerAddresses addresses_from(std::string_view line) {
  const Json json = Json::parse(line, nullptr, false);
  const auto text = [&](const char* key) {
    const auto found = json.is_object() ? json.find(key) : json.end();
    return json.is_object() && found != json.end() && found->is_string() ? found->get<std::string>()
                                                                         : std::string();
  };
  ServerAddresses out{text("http"), text("listen")};
  if (out.http.empty() || out.listen.empty())
    throw Error(ErrorKind::failed,
                fmt::format("the coordinator did not say where it listens, but \"{}\"",
                            line.substr(0, 200)));
  return out;
}

int threads_of_each(int asked, int workers) {
  return asked > 0 ? asked : std::max(1, processors() / workers);
}

int processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) != 0) return 1;
  return std::max(1, CPU_COUNT(&set));
}

Farm::Farm(int workers, int threads) {
  const fs::path server = beside("tessera-server"), worker = beside("tessera-worker");
  folder_ = temporary_folder();
  try {
    const auto log = [&](const std::string& name) { return folder_ / (name + ".log"); };
    const std::vector<std::string> arguments{
        "--data", (folder_ / "data").string(), "--http", "127.0.0.1:0", "--listen", "127.0.0.1:0"};
    children_.push_back(
        std::make_unique<Child>("the coordinator", server, arguments, log("server")));
    const auto line = children_.front()->first_line(start_time);
    if (!line) {
      children_.front()->end_within(std::chrono::seconds(1));
      throw Error(ErrorKind::failed, children_.front()->epitaph());
    }
    const ServerAddresses addresses = addresses_from(*line);
    url_ = "http://" + addresses.http;
    for (int i = 1; i <= workers; ++i) {
      const std::string name = fmt::format("local-{}", i);
      children_.push_back(std::make_unique<Child>(
          fmt::format("worker {}", i), worker,
          std::vector<std::string>{"--server", addresses.listen, "--threads",
                                   std::to_string(threads), "--name", name, "--cache",
                                   (folder_ / "cache").string()},
          log(name)));
    }
  } catch (...) {
    children_.clear();
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
    throw;
  }
}

Farm::~Farm() {
  // Workers first, so that the coordinator sees them say goodbye.
  for (auto child = children_.rbegin(); child != children_.rend(); ++child) (*child)->ask_to_end();
  const auto end =
      std::chrono::steady_clock::now() + (interrupt_noted() ? end_time_interrupted : end_time);
  for (auto child = children_.rbegin(); child != children_.rend(); ++child)
    (*child)->end_within(
        std::max<Duration>(end - std::chrono::steady_clock::now(), Duration::zero()));
  children_.clear();
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

void Farm::check() {
  for (const auto& child : children_)
    if (!child->running()) throw Error(ErrorKind::failed, child->epitaph());
}

}  // namespace tessera::client
