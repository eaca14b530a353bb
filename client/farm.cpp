#include "client/farm.hpp"

#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "client/interrupt.hpp"
#include "common/base/error.hpp"
#include "common/base/json.hpp"

namespace tessera::client {

namespace fs = std::filesystem;

namespace {

constexpr std::chrono::seconds start_time{30};
constexpr int restarts_most = 3;  // of each worker
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
  const auto log = [&](const std::string& name) { return folder_.path() / (name + ".log"); };
  const std::vector<std::string> arguments{"--data",   (folder_.path() / "data").string(),
                                           "--http",   "127.0.0.1:0",
                                           "--listen", "127.0.0.1:0"};
  server_ = std::make_unique<Child>("the coordinator", server, arguments, log("server"));
  const auto line = server_->first_line(start_time);
  if (!line) {
    server_->end_within(std::chrono::seconds(1));
    throw Error(ErrorKind::failed, server_->epitaph());
  }
  const ServerAddresses addresses = addresses_from(*line);
  url_ = "http://" + addresses.http;
  for (int i = 1; i <= workers; ++i) {
    const std::string name = fmt::format("local-{}", i);
    const std::vector<std::string> how{"--server",  addresses.listen,
                                       "--threads", std::to_string(threads),
                                       "--name",    name,
                                       "--cache",   (folder_.path() / "cache").string()};
    Seat seat;
    seat.start = [worker, how, title = fmt::format("worker {}", i), file = log(name)] {
      return std::make_unique<Child>(title, worker, how, file);
    };
    seat.child = seat.start();
    seats_.push_back(std::move(seat));
  }
}

Farm::~Farm() {
  // Workers first, so that the coordinator sees them say goodbye.
  std::vector<Child*> all;
  for (const Seat& seat : seats_) all.push_back(seat.child.get());
  if (server_) all.push_back(server_.get());
  for (Child* child : all) child->ask_to_end();
  const auto end =
      std::chrono::steady_clock::now() + (interrupt_noted() ? end_time_interrupted : end_time);
  for (Child* child : all)
    child->end_within(std::max<Duration>(end - std::chrono::steady_clock::now(), Duration::zero()));
}

void Farm::check(ProgressPrinter& printer) {
  if (!server_->running()) throw Error(ErrorKind::failed, server_->epitaph());
  bool any = false;
  for (Seat& seat : seats_) {
    if (seat.child->running()) {
      any = true;
      continue;
    }
    if (seat.given_up) continue;
    seat.given_up = seat.restarts >= restarts_most;
    const std::string epitaph = seat.child->epitaph();
    printer.say(fmt::format("tessera: {}; {}", epitaph.substr(0, epitaph.find('\n')),
                            seat.given_up ? "it is not started again" : "it is started again"));
    if (seat.given_up) continue;
    ++seat.restarts;
    seat.child = seat.start();
    any = true;
  }
  if (!any)
    throw Error(ErrorKind::failed,
                "no worker is left; the last: " + seats_.back().child->epitaph());
}

}  // namespace tessera::client
