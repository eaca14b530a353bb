// tessera_sim_measure [--promise | --all]: what the scheduler makes of many workers, without any
// fault. Tables on standard output; exit code 1 if a promise is not kept: at least 95 % of the work
// that is possible is done at 1,000 workers of speeds 1 to 10, in a million tasks, with and without
// copies. --promise: that table alone; --all: with 10,000 workers, too.
#include <fmt/format.h>

#include <cstdio>
#include <string_view>

#include "tests/sim/model.hpp"

namespace {

using tessera::sim::measure;
using tessera::sim::Measured;
using tessera::sim::Model;

void head() {
  fmt::print("{:>8} {:>7} {:>9} {:>7} {:>9} {:>9} {:>7} {:>11} {:>8} {:>8}\n", "workers", "speeds",
             "tasks", "copies", "seconds", "ideal", "tail", "tail ideal", "effic.", "wasted");
}

Measured line(const Model& model) {
  const Measured measured = measure(model);
  fmt::print("{:>8} {:>7} {:>9} {:>7} {:>9.1f} {:>9.1f} {:>7.2f} {:>11.2f} {:>7.2f}% {:>7.2f}%\n",
             model.workers, fmt::format("1-{:.0f}", model.spread), measured.tasks,
             model.copies_most - 1, measured.seconds, measured.ideal, measured.tail,
             measured.tail_ideal, 100 * measured.efficiency(), 100 * measured.wasted);
  std::fflush(stdout);
  return measured;
}

constexpr double promised = 0.95;

void frames() {
  fmt::print("One 4K frame (2,040 tiles, 1,024 samples), 5 s a task of 256 samples\n");
  head();
  for (const int workers : {10, 100, 1000}) {
    for (const double spread : {1.0, 10.0}) {
      for (const int copies : {1, 3}) {
        Model model;
        model.workers = workers;
        model.spread = spread;
        model.copies_most = copies;
        line(model);
      }
    }
  }
  fmt::print("\nThe same, and one worker in ten falls to a tenth of its speed\n");
  head();
  for (const int workers : {10, 100, 1000}) {
    for (const int copies : {1, 3}) {
      Model model;
      model.workers = workers;
      model.slowdown = 0.1;
      model.copies_most = copies;
      line(model);
    }
  }
  fmt::print("\n");
}

/// True if the promise is kept.
bool night(bool all) {
  bool kept = true;
  fmt::print("A night's frame: a million tasks\n");
  head();
  for (const int workers : {1000, 10000}) {
    if (workers > 1000 && !all) continue;
    for (const int copies : {1, 3}) {
      Model model;
      model.workers = workers;
      model.tiles = 125'000;
      model.copies_most = copies;
      const Measured measured = line(model);
      if (workers == 1000)
        kept = kept && measured.tasks >= 1'000'000 && measured.efficiency() >= promised;
    }
  }
  if (!kept) fmt::print("efficiency at 1,000 workers is below {:.0f} %\n", 100 * promised);
  return kept;
}

}  // namespace

int main(int count, char** arguments) {
  const std::string_view flag = count > 1 ? arguments[1] : "";
  if (count > 2 || (!flag.empty() && flag != "--all" && flag != "--promise")) {
    std::fputs("tessera_sim_measure [--promise | --all]\n", stderr);
    return 2;
  }
  if (flag != "--promise") frames();
  return night(flag == "--all") ? 0 : 1;
}
