#pragma once
#include <cstdint>
#include <vector>

/// A calm farm in virtual time, as lean as can be: the real scheduler and workers of differing
/// speeds, to measure what it makes of ten thousand of them.
namespace tessera::sim {

struct Model {
  std::uint64_t seed = 1;
  int workers = 100;
  double spread = 10;  ///< speeds are uniform in [1, spread]
  std::uint32_t tiles = 2040;
  std::int64_t samples = 1024;
  double task_seconds = 5;  ///< of 256 samples of an average tile, at speed 1 + spread / 2
  double roughness = 0.5;   ///< σ of the logarithm of a tile's cost
  double overhead = 0.001;  ///< seconds a task, in the worker
  double latency = 0.001;   ///< seconds, one way
  double slowdown = 0;      ///< chance that a worker falls to a tenth of its speed at some instant
  int copies_most = 3;
};

struct Measured {
  double seconds = 0;     ///< from the first lease to the last fold
  double ideal = 0;       ///< all work, at the speed of all workers
  double tail = 0;        ///< from the last first attempt handed out to the last fold
  double tail_ideal = 0;  ///< what was left of the work then, at the speed of all workers
  double wasted = 0;      ///< worker seconds spent on what came second, as a share of all
  std::int64_t tasks = 0, grants = 0;
  [[nodiscard]] double efficiency() const { return ideal / seconds; }
};

Measured measure(const Model& model);

}  // namespace tessera::sim
