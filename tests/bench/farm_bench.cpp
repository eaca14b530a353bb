// The farm measured on real processes: what it costs beside the renderer alone, what a result costs
// the coordinator, how many it takes a second, and how long a worker idles between tasks. Each
// figure is a ratio within this run, or a count.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <thread>

#include "tests/bench/flood.hpp"
#include "tests/bench/print.hpp"
#include "tests/farm/farm.hpp"
#include "tests/farm/reordering_proxy.hpp"

namespace tessera::farm_test {
namespace {

using Clock = std::chrono::steady_clock;

std::string cornell() { return (sources() / "scenes/cornell.json").string(); }

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

/// CPU seconds, user and system, of a command and all that it started and waited for; negative if
/// it failed.
double cpu_seconds(const std::vector<std::string>& arguments) {
  std::vector<char*> pointers;
  std::vector<std::string> owned = arguments;
  for (std::string& argument : owned) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    if (std::freopen("/dev/null", "w", stdout) == nullptr ||
        std::freopen("/dev/null", "w", stderr) == nullptr)
      _exit(126);
    execv(pointers[0], pointers.data());
    _exit(127);
  }
  int status = 0;
  rusage used{};
  if (wait4(child, &status, 0, &used) != child || status != 0) return -1;
  const auto in_seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return in_seconds(used.ru_utime) + in_seconds(used.ru_stime);
}

/// What a running process has used so far.
struct Used {
  double user = 0, system = 0;  ///< CPU seconds
  double faults = 0;            ///< pages that came when they were first touched
};

Used used_by(pid_t pid) {
  const std::string text = read_text("/proc/" + std::to_string(pid) + "/stat");
  std::istringstream fields(text.substr(text.rfind(')') + 2));
  std::string skipped;
  Used used;
  for (int field = 3; field < 10; ++field) fields >> skipped;
  fields >> used.faults;
  for (int field = 11; field < 14; ++field) fields >> skipped;
  fields >> used.user >> used.system;
  const auto ticks = static_cast<double>(sysconf(_SC_CLK_TCK));
  used.user /= ticks;
  used.system /= ticks;
  return used;
}

/// The farm's CPU time over the renderer's, both in turn, so that the machine's drift cancels.
void overhead(int pairs, int size, int samples) {
  const std::string film = std::to_string(size) + "x" + std::to_string(size);
  const std::string spp = std::to_string(samples);
  const TemporaryFolder folder;
  for (const auto& [workers, threads] : {std::pair(2, 1), std::pair(1, 2)}) {
    std::vector<double> ratios;
    for (int pair = 0; pair < pairs; ++pair) {
      const double direct =
          cpu_seconds({(programs() / "bench_direct").string(), cornell(), film, spp, "2"});
      const double farm =
          cpu_seconds({(programs() / "tessera").string(), "render", cornell(), "-o",
                       (folder / "out.exr").string(), "--size", film, "--samples", spp, "--workers",
                       std::to_string(workers), "--threads", std::to_string(threads)});
      if (direct <= 0 || farm <= 0) {
        std::printf("overhead: a run failed\n");
        return;
      }
      std::printf("  pair %d: renderer %.2f s, farm %.2f s\n", pair + 1, direct, farm);
      std::fflush(stdout);
      ratios.push_back(farm / direct);
    }
    print("CPU of farm over renderer, " + std::to_string(workers) + " x " +
              std::to_string(threads) + " threads, median",
          median(ratios), "ratio", "at most 1.05");
  }
}

/// One job after another, as a coordinator has them; the count is of all.
struct Load {
  int film = 512, tile = 64, samples = 256, jobs = 1;
};

void results(const Load& load, const std::string& aim_rate, const std::string& aim_cpu) {
  Farm farm;
  const std::string side = std::to_string(load.film), tile = std::to_string(load.tile);
  const Used before = used_by(farm.server().pid());
  const auto started = Clock::now();
  const Floods floods(farm.listen(), 2);
  for (int job = 0; job < load.jobs; ++job) {
    const std::string id = farm.submit(cornell(), {"--size", side + "x" + side, "--tile", tile,
                                                   "--samples", std::to_string(load.samples)});
    if (farm.tessera({"wait", id}).code != 0)
      std::printf("results: a job did not finish\n%s\n", farm.logs().c_str());
  }
  const double took = std::chrono::duration<double>(Clock::now() - started).count();
  const Used after = used_by(farm.server().pid());
  const auto count = static_cast<double>(floods.delivered());
  std::printf("film %s, tiles of %s, %d samples, %d jobs, %.0f results:\n", side.c_str(),
              tile.c_str(), load.samples, load.jobs, count);
  const double user = after.user - before.user, system = after.system - before.system;
  if (!aim_rate.empty())
    print("results decoded, journaled, folded, acknowledged", count / took, "1/s", aim_rate);
  print("coordinator's CPU time per result, the final EXR included", 1e6 * (user + system) / count,
        "us", aim_cpu);
  print("  of it in the system", 1e6 * system / count, "us", "");
  print("  page faults per result", (after.faults - before.faults) / count, "", "");
  print("coordinator's peak memory", farm.server().peak_memory(), "MiB", "");
}

void idle_gap() {
  Farm farm;
  const ReorderingProxy proxy(farm.listen(), 1);
  Process& worker = farm.add_worker(1, proxy.address());
  farm.finish(farm.submit(cornell(), {"--size", "512x512", "--samples", "64"}));
  const auto seen = proxy.seen();
  if (seen.size() < 10) {
    std::printf("idle gap: too few results\n");
    return;
  }
  double rendering = 0;
  for (std::size_t i = 1; i < seen.size(); ++i) rendering += seen[i].seconds;
  const double wall = std::chrono::duration<double>(seen.back().when - seen.front().when).count();
  print("idle gap of a worker between tasks, mean",
        1e3 * (wall - rendering) / static_cast<double>(seen.size() - 1), "ms", "under 5");
  print("worker's peak memory, Cornell box", worker.peak_memory(), "MiB", "");
}

}  // namespace
}  // namespace tessera::farm_test

/// bench_farm [--quick | --results]: with --quick fewer pairs of a smaller picture, to see that it
/// runs; with --results only what a result costs the coordinator.
int main(int count, char** arguments) {
  using namespace tessera::farm_test;
  const auto asked = [&](const char* option) {
    return count > 1 && std::strcmp(arguments[1], option) == 0;
  };
  results({.film = 1024, .tile = 16, .samples = 16}, "at least 10000", "");
  results({.film = 512, .tile = 64, .samples = 256, .jobs = 10}, "", "at most 300");
  results({.film = 2048, .tile = 64, .samples = 16}, "",
          "");  // each with AOVs, three passes a frame
  if (asked("--results")) return 0;
  idle_gap();
  if (asked("--quick"))
    overhead(1, 128, 64);
  else
    overhead(3, 512, 256);
  return 0;
}
