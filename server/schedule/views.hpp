#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "common/base/digest.hpp"
#include "server/schedule/actions.hpp"

/// What the scheduler shows of workers and jobs; all counts are of the present.
namespace tessera::server {

/// What a worker said of itself in its hello.
struct WorkerInfo {
  std::string name;
  std::string identity;
  int threads = 1;
  Digest build_id;
};

struct WorkerView {
  WorkerId id = 0;
  WorkerInfo info;
  /// "idle", "preparing", "rendering", "stalled" (its leases expired), "draining", "quarantined"
  std::string state;
  std::string reason;  ///< why it is quarantined
  std::size_t leases = 0;
  std::int64_t tasks_done = 0;
  double samples_per_second = 0;  ///< measured, smoothed
  double silent_seconds = 0;
};

struct JobView {
  JobId id = 0;
  std::string state;  ///< "queued", "rendering", "paused", "done", "failed", "cancelled"
  std::int64_t tasks = 0, tasks_done = 0, leased = 0;
  std::int64_t samples = 0, samples_done = 0;  ///< pixels × samples
  double samples_per_second = 0;               ///< of all its workers at present
  std::optional<double> eta_seconds;
  std::optional<double> eta_low_seconds, eta_high_seconds;  ///< hold the truth four times in five
  std::string error;
  std::string waiting_for;  ///< why it has work and none of it is out; empty: no such reason
  int priority = 0;
  std::optional<Digest> build;  ///< of its first worker; it takes no others unless mixed
};

}  // namespace tessera::server
