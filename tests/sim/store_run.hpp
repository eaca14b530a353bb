#pragma once
#include <array>
#include <cstdint>
#include <string>

#include "tests/sim/disk/faults.hpp"

/// The real store alone on the simulated disk, as hard as it can be: most seeds fail every few
/// changes.
namespace tessera::sim {

struct StoreOutcome {
  std::string violation;  // empty: every rule held
  std::uint64_t trace = 0, points = 0, calls = 0, lives = 0, sectors_lost = 0;
  std::array<std::uint64_t, fault_kinds> faults{};
  [[nodiscard]] std::uint64_t fault_events() const;
};

struct StoreRunOptions {
  bool trace = false;          ///< each point and each call on standard output
  std::uint64_t fault_at = 0;  ///< one fault at this point, and no other
  Fault fault = Fault::none;
};

/// One run from one seed: what is asked of the store, and when the disk fails, are drawn from it.
StoreOutcome run_store(std::uint64_t seed, const StoreRunOptions& options = {});

}  // namespace tessera::sim
