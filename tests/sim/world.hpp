#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "tests/sim/bug.hpp"
#include "tests/sim/disk/sim_disk.hpp"
#include "tests/sim/events.hpp"
#include "tests/sim/ledger.hpp"
#include "tests/sim/network.hpp"

namespace tessera::sim {

class Coordinator;

/// How hostile a run is; drawn from its seed.
struct Weather {
  double latency_most = 0.02;
  double cut_every = 1e9;  // seconds between cut connections, over all workers
  double half_open = 0.3;  // share of cuts that the coordinator does not notice
  double crash_every = 1e9;
  double silence_every = 1e9;
  double restart_every = 1e9;  // of the coordinator
  double partition_every = 1e9;
  double return_chance = 0;  // that a worker that comes is one that was there before
  double leave_every = 1e9;  // clean
  double duplicate = 0;      // chance that a result is sent twice
  double late = 0;           // chance that a result is held back
  double error = 0;          // chance that a task fails, once
  double corrupt = 0;        // chance that a result is no valid tile, once
  double sync_most = 0.02;
  double fold_most = 0.01;
  FaultWeather drive;
  double power = 0;        // share of the coordinator's restarts that are power cuts
  double calm_after = 60;  // seconds: from here on nothing bad happens
};

/// What all parts of one run share.
struct World {
  explicit World(std::uint64_t seed);

  Events events;
  Random random;
  Weather weather;
  Bug bug = Bug::none;
  SimDisk drive;
  std::uint64_t segment_bytes = 0;
  std::uint64_t compact_bytes = 0;  // of a frame in the journal: then its film is kept whole
  Disk disk;
  int unanswered = 0;  // jobs that clients have not got taken yet
  Acknowledged acknowledged;
  std::set<std::pair<JobId, TaskId>>
      spoiled;              // tasks that have had their error or their corrupt result
  std::uint64_t trace = 0;  // hash of all that was decided
  std::uint64_t faults = 0;
  std::uint64_t decisions = 0;
  std::uint64_t checkpoints = 0, shortened = 0, frames_shortened = 0;

  std::unique_ptr<Coordinator> coordinator;
  std::vector<std::unique_ptr<Worker>> workers;

  ~World();

  [[nodiscard]] bool calm() const { return events.seconds_now() >= weather.calm_after; }
  bool tracing = false;
  template <class... Args>
  void tell(fmt::format_string<Args...> format, Args&&... args) const {
    if (tracing)
      fmt::print("{:9.3f} {}\n", events.seconds_now(),
                 fmt::format(format, std::forward<Args>(args)...));
  }
  void note(std::uint64_t value) {
    trace = (trace ^ value) * 0x9e3779b97f4a7c15ULL + (trace >> 29);
  }
  /// True once per task at most, with this chance.
  bool spoil(double probability, JobId job, const TaskId& task) {
    return !calm() && random.chance(probability) && spoiled.emplace(job, task).second &&
           ++faults > 0;
  }
  /// Brings `what` to the other side if the connection still stands then.
  void carry(const Link& link, bool to_server, std::function<void()> what) {
    Instant& last = to_server ? link->to_server_at : link->to_worker_at;
    const Instant healed = to_server ? link->partition->to_server : link->partition->to_worker;
    last = std::max(
        {last, healed, events.now() + from_seconds(random.between(0.0002, weather.latency_most))});
    events.at(last, [link, what = std::move(what)] {
      if (link->open) what();
    });
  }
  /// The disk's faults, too, come to an end.
  void begin_calm() { drive.faults.set({}); }
  /// Both ends learn of it, the coordinator only if it `notices`.
  void cut(const Link& link, bool notices);
};

}  // namespace tessera::sim
