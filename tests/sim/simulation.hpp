#pragma once
#include <cstdint>
#include <string>

#include "tests/sim/bug.hpp"

namespace tessera::sim {

struct Outcome {
  std::string violation;  // empty: every rule held
  std::uint64_t trace = 0, events = 0, faults = 0, decisions = 0, tasks = 0;
  std::uint64_t checkpoints = 0, shortened = 0, frames_shortened = 0;
  double virtual_seconds = 0;
};

/// One run from one seed: jobs, workers and weather are drawn from it. With `trace` what happens is
/// told on standard output.
Outcome run(std::uint64_t seed, Bug bug = Bug::none, bool trace = false);

}  // namespace tessera::sim
