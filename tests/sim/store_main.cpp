// tessera_sim_store [--seeds N] [--first N] [--at-least EVENTS] [--seed N]: the real store on the
// simulated disk for N seeds, or for as many as it takes to reach so many fault events; or one seed
// again, with its trace. Exit code 1 if a rule was broken.
#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string_view>

#include "common/base/log.hpp"
#include "tests/sim/store_run.hpp"

namespace {

using tessera::sim::Fault;
using tessera::sim::StoreOutcome;

int usage() {
  std::fputs("tessera_sim_store [--seeds N] [--first N] [--at-least EVENTS] | --seed N\n", stderr);
  return 2;
}

struct Totals {
  std::uint64_t seeds = 0, points = 0, events = 0, calls = 0, lives = 0, sectors = 0;
  std::array<std::uint64_t, tessera::sim::fault_kinds> faults{};
  void add(const StoreOutcome& outcome) {
    ++seeds;
    points += outcome.points;
    events += outcome.fault_events();
    calls += outcome.calls;
    lives += outcome.lives;
    sectors += outcome.sectors_lost;
    for (std::size_t i = 0; i < faults.size(); ++i) faults.at(i) += outcome.faults.at(i);
  }
  void print() const {
    fmt::print("{} seeds, {} calls, {} starts, {} fault points, {} fault events (", seeds, calls,
               lives, points, events);
    for (std::size_t i = 1; i < faults.size(); ++i)
      fmt::print("{}{} {}", i > 1 ? ", " : "", faults.at(i), tessera::sim::fault_names.at(i));
    fmt::print("; {} sectors lost): every rule held ({:.1f} s of CPU)\n", sectors,
               static_cast<double>(std::clock()) / CLOCKS_PER_SEC);
  }
};

}  // namespace

int main(int count, char** arguments) {
  std::uint64_t first = 1, seeds = 200, at_least = 0;
  bool one = false;
  for (int i = 1; i < count; ++i) {
    const std::string_view flag = arguments[i];
    if (i + 1 >= count) return usage();
    const std::uint64_t value = std::strtoull(arguments[++i], nullptr, 10);
    if (flag == "--seeds") {
      seeds = value;
    } else if (flag == "--first") {
      first = value;
    } else if (flag == "--at-least") {
      at_least = value;
    } else if (flag == "--seed") {
      first = value, seeds = 1, one = true;
    } else {
      return usage();
    }
  }
  tessera::log::set_level(tessera::log::Level::error);
  Totals totals;
  for (std::uint64_t seed = first; seed < first + seeds || totals.events < at_least; ++seed) {
    const StoreOutcome outcome = tessera::sim::run_store(seed, {.trace = one});
    totals.add(outcome);
    std::string broken = outcome.violation;
    if (broken.empty() && seed % 50 == 1 && tessera::sim::run_store(seed).trace != outcome.trace)
      broken = "two runs differ";
    if (broken.empty()) continue;
    fmt::print("seed {}: {}\n  replay: tessera_sim_store --seed {}\n", seed, broken, seed);
    return 1;
  }
  totals.print();
  return 0;
}
