// The coordinator measured on its own: results merged a second with and without durability, the
// time from a kill to the first lease, memory for a film and for a worker. Workers render nothing.
#include <chrono>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "tests/bench/flood.hpp"
#include "tests/bench/print.hpp"
#include "tests/farm/crowd.hpp"
#include "tests/farm/farm.hpp"
#include "tests/farm/reference.hpp"

namespace tessera::farm_test {
namespace {

using Clock = std::chrono::steady_clock;

double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct Load {
  int width = 3840, height = 2160, samples = 256;
};

std::vector<std::string> job_of(const Load& load) {
  return {"--size", std::to_string(load.width) + "x" + std::to_string(load.height), "--samples",
          std::to_string(load.samples)};
}

/// What the process holds now, MiB: "VmRSS"; "RssAnon" is what it allocated.
double memory_now(pid_t pid, const std::string& kind) {
  std::istringstream status(read_text("/proc/" + std::to_string(pid) + "/status"));
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(kind + ":")) return std::stod(line.substr(kind.size() + 1)) / 1024;
  return 0;
}

/// MB of EXR tiles a second, from the first order to the last fold.
double merged(const Load& load, bool durable) {
  FarmSettings settings;
  if (!durable) settings.flags = {"--no-durable"};
  Farm farm(settings);
  const Floods floods(farm.listen(), 2);
  const auto started = Clock::now();
  const std::string id = farm.submit(scene_path(), job_of(load));
  if (!farm.wait_for_progress(id, 1, Seconds(600)))
    throw std::runtime_error("a job did not finish\n" + farm.logs());
  return 1e-6 * static_cast<double>(floods.bytes()) / since(started);
}

void merge_rates(const Load& load, int pairs) {
  for (int pair = 0; pair < pairs; ++pair) {
    const double kept = merged(load, true), not_synced = merged(load, false);
    print("results merged, synced before they are acknowledged", kept, "MB/s", "");
    print("results merged, never synced (--no-durable)", not_synced, "MB/s", "");
    print("  durable over not", kept / not_synced, "ratio", "");
  }
}

/// Seconds until a worker that tries again every millisecond has its first lease.
double until_first_lease(const Farm& farm, Clock::time_point start) {
  for (int tries = 0; since(start) < 60; ++tries) {
    try {
      ScriptedHello hello;
      hello.identity.replace(0, 1, "f");
      ScriptedWorker worker(farm.listen(), hello);
      while (const auto heard = worker.hear(Seconds(10)))
        if (std::holds_alternative<wire::Assign>(*heard)) return since(start);
    } catch (const std::runtime_error&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  throw std::runtime_error("no lease after the restart\n" + farm.logs());
}

/// A film half done: what it costs in memory, and how soon a killed coordinator leases again.
void half_done(const Load& load, const std::string& aim) {
  Farm farm;
  const double idle = memory_now(farm.server().pid(), "RssAnon");
  std::string id;
  {
    const Floods floods(farm.listen(), 2);
    id = farm.submit(scene_path(), job_of(load));
    if (!farm.wait_for_progress(id, 0.5, Seconds(600)))
      throw std::runtime_error("the film did not become half done\n" + farm.logs());
  }
  std::this_thread::sleep_for(std::chrono::seconds(1));  // what was in flight is folded
  const std::string film = std::to_string(load.width) + "x" + std::to_string(load.height);
  const nlohmann::json job = farm.job(id);
  std::printf("film %s, %d samples, %.0f %% done, %d results:\n", film.c_str(), load.samples,
              100 * job.at("progress").get<double>(), job.at("tasks_done").get<int>());
  print("coordinator's memory for the film", memory_now(farm.server().pid(), "RssAnon") - idle,
        "MiB", "");
  print("  at most, while results came", farm.server().peak_memory(), "MiB", "");
  std::optional<double> leased;
  std::thread waiting;
  const auto killed = Clock::now();
  farm.server().kill();
  waiting = std::thread([&] { leased = until_first_lease(farm, killed); });
  farm.start_killed_server();
  waiting.join();
  print("from a kill of the coordinator to the first lease", leased.value_or(-1), "s", aim);
  print("coordinator's memory after the restart", memory_now(farm.server().pid(), "RssAnon"), "MiB",
        "");
}

void memory_of_workers(std::size_t count) {
  Farm farm;
  const double before = memory_now(farm.server().pid(), "RssAnon");
  const Crowd crowd(farm.listen(), count);
  if (!crowd.wait_for_welcomes(count, Seconds(60))) throw std::runtime_error(crowd.troubles());
  std::this_thread::sleep_for(std::chrono::seconds(2));  // heartbeats
  const double after = memory_now(farm.server().pid(), "RssAnon");
  print("coordinator's memory for a connected worker, of " + std::to_string(count),
        1024 * (after - before) / static_cast<double>(count), "KiB", "");
}

}  // namespace
}  // namespace tessera::farm_test

/// bench_coordinator [--quick]: with it, smaller films, to see that it runs.
int main(int count, char** arguments) {
  using namespace tessera::farm_test;
  const bool quick = count > 1 && std::strcmp(arguments[1], "--quick") == 0;
  const Load film = quick ? Load{960, 540, 256} : Load{};
  const Load passes = quick ? Load{512, 512, 64} : Load{1920, 1080, 256};
  merge_rates(passes, quick ? 1 : 3);
  half_done(film, quick ? "" : "under 2");
  memory_of_workers(quick ? 100 : 1000);
  return 0;
}
