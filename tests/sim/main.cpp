// tessera_sim [--seeds N] [--first N] [--seed N] [--bug NAME]: runs the simulation for N seeds, or
// one seed again. Exit code 1 if a rule was broken; with --bug or --bugs, if one was not found: by
// a rule, or with --bugs by an assertion.
#include <fmt/format.h>

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <utility>

#include "common/base/log.hpp"
#include "tests/sim/simulation.hpp"

namespace {

using tessera::sim::Bug;

constexpr std::array<std::pair<std::string_view, Bug>, 7> bugs{
    {{"none", Bug::none},
     {"fold-out-of-order", Bug::fold_out_of_order},
     {"double-fold", Bug::double_fold},
     {"acknowledge-before-commit", Bug::acknowledge_before_commit},
     {"keep-without-asking", Bug::keep_without_asking},
     {"forget-lost-worker", Bug::forget_lost_worker},
     {"ignore-fold-limit", Bug::ignore_fold_limit}}};

struct Options {
  std::uint64_t first = 1, seeds = 200;
  bool one = false;
  Bug bug = Bug::none;
  bool all_bugs = false;
};

int usage() {
  std::fputs("tessera_sim [--seeds N] [--first N] [--seed N] [--bug NAME | --bugs]\n", stderr);
  return 2;
}

/// What is said of an assertion that ends the process: the seed it was at.
std::string last_words;

extern "C" void say_last_words(int) {
  static_cast<void>(::write(STDOUT_FILENO, last_words.data(), last_words.size()));
}

/// Runs until the first broken rule; true if there was one.
bool broken(const Options& options, Bug bug) {
  std::uint64_t events = 0, faults = 0, tasks = 0, decisions = 0, checkpoints = 0, shortened = 0;
  std::uint64_t frames_shortened = 0;
  const auto began = std::chrono::steady_clock::now();
  for (std::uint64_t seed = options.first; seed < options.first + options.seeds; ++seed) {
    last_words = fmt::format("seed {}: an assertion did not hold\n", seed);
    const tessera::sim::Outcome outcome = tessera::sim::run(seed, bug, options.one);
    events += outcome.events;
    faults += outcome.faults;
    tasks += outcome.tasks;
    decisions += outcome.decisions;
    checkpoints += outcome.checkpoints;
    shortened += outcome.shortened;
    frames_shortened += outcome.frames_shortened;
    if (!outcome.violation.empty()) {
      fmt::print("seed {}: {}\n  replay: tessera_sim --seed {}\n", seed, outcome.violation, seed);
      return true;
    }
    if (options.one)
      fmt::print("seed {}: {:.0f} virtual seconds, trace {:016x}\n", seed, outcome.virtual_seconds,
                 outcome.trace);
    if (seed % 20 == 1 && tessera::sim::run(seed, bug).trace != outcome.trace) {
      fmt::print("seed {}: two runs decide differently\n", seed);
      return true;
    }
  }
  const double took =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  fmt::print(
      "{} seeds, {} tasks, {} grants, {} checkpoints, {} jobs and {} frames ended before all "
      "samples, {} "
      "events, {} faults: every rule held ({:.1f} s)\n",
      options.seeds, tasks, decisions, checkpoints, shortened, frames_shortened, events, faults,
      took);
  return false;
}

/// True if a bug is found, be it by an assertion of the code under test, which ends its process.
bool found(const Options& options, Bug bug) {
  std::fflush(stdout);
  const ::pid_t child = ::fork();
  if (child == 0) {
    const bool seen = broken(options, bug);
    std::fflush(stdout);
    ::_exit(seen ? 0 : 1);
  }
  int status = 0;
  if (child < 0 || ::waitpid(child, &status, 0) != child) return false;
  return WIFEXITED(status) ? WEXITSTATUS(status) == 0
                           : WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT;
}

}  // namespace

int main(int count, char** arguments) {
  static_cast<void>(std::signal(SIGABRT, say_last_words));
  tessera::log::set_level(tessera::log::Level::error);  // what the disk does is no news here
  Options options;
  for (int i = 1; i < count; ++i) {
    const std::string_view flag = arguments[i];
    if (flag == "--bugs") {
      options.all_bugs = true;
      continue;
    }
    if (i + 1 >= count) return usage();
    const std::string value = arguments[++i];
    if (flag == "--seeds") {
      options.seeds = std::strtoull(value.c_str(), nullptr, 10);
    } else if (flag == "--first") {
      options.first = std::strtoull(value.c_str(), nullptr, 10);
    } else if (flag == "--seed") {
      options.first = std::strtoull(value.c_str(), nullptr, 10);
      options.seeds = 1;
      options.one = true;
    } else if (flag == "--bug") {
      bool known = false;
      for (const auto& [name, bug] : bugs) {
        if (name == value) options.bug = bug, known = true;
      }
      if (!known) return usage();
    } else {
      return usage();
    }
  }
  if (options.all_bugs) {
    int missed = 0;
    for (const auto& [name, bug] : bugs) {
      if (bug == Bug::none) continue;
      fmt::print("{}: ", name);
      if (!found(options, bug)) {
        fmt::print("{} was NOT found\n", name);
        ++missed;
      }
    }
    return missed == 0 ? 0 : 1;
  }
  return broken(options, options.bug) == (options.bug != Bug::none) ? 0 : 1;
}
