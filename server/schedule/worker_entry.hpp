#pragma once
#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "common/base/clock.hpp"
#include "server/schedule/meter.hpp"
#include "server/schedule/scheduler.hpp"

namespace tessera::server {

/// A lease that a worker holds.
struct HeldLease {
  LeaseId id;
  JobId job = 0;
  TaskId task;
  std::int64_t samples = 0;
  Instant granted{};
  bool runs = false;    // it has said so
  double fraction = 0;  // as last reported
  double counted = 0;   // … when its worker was last measured
  Instant advanced{};   // last time that this got on, from when it ran
  Duration stall{};     // it may stand still for so long
};

/// A connected worker as the scheduler knows it.
struct WorkerEntry {
  WorkerEntry(WorkerId number, WorkerInfo said, Instant now)
      : id(number), info(std::move(said)), joined(now), heard(now), advanced(now), got_on(now) {}

  /// It lives, and what it has to do gets on.
  void gets_on(Instant now) { heard = advanced = got_on = now; }
  /// … or would have been seen to: so does each lease that it runs.
  void excused(Instant now) {
    gets_on(now);
    for (auto& [number, held] : leases)
      if (held.runs) held.advanced = now;
  }

  /// What it has to do with one job.
  struct Part {
    Instant begun{};                // its first lease, or when a scene was to be built again
    bool ready = false;             // the scene is built, as far as is known
    double fraction = 0;            // of its preparation, as last said
    std::int64_t samples_held = 0;  // of its leases
    Meter speed;                    // samples a second
    Meter power{20};                // work a second, in the units of WorkLeft
  };

  WorkerId id;
  WorkerInfo info;
  bool draining = false;
  bool barred = false;  // its name is quarantined: granted nothing
  bool told_barred = false;
  bool offended = false;  // … just now: its connection is to end
  bool alone = false;     // what it holds is a suspect
  std::optional<std::pair<JobId, TaskId>>
      reserved;  // the suspect that it will run when it holds nothing else
  std::map<std::uint64_t, HeldLease> leases;  // by number: oldest first
  /// Leases that expired and that it has not let go of, as far as is known.
  std::set<LeaseId> expired;
  /// It builds this job's scene though it holds no lease of it, so that it can build no other: said
  /// anew with each progress.
  std::optional<JobId> hung;
  bool hung_said = false;    // since its last progress
  bool hung_counts = false;  // it was given up there: more of it is held against the job
  std::map<JobId, Part> parts;
  std::int64_t tasks_done = 0;
  Instant joined;
  int errors_in_row = 0;

  Instant heard;         // last byte
  Instant advanced;      // last time that any of its leases got on, or it said that it prepares
  Instant got_on;        // … or its preparation did
  Instant busy_since{};  // up to where its speed has been measured
  Instant reported{};    // last progress
  std::optional<Instant> rests;  // after errors: granted nothing until then
  std::optional<Instant> timer;  // when it is to be looked at

  /// Its speed has been measured up to now.
  void measured(Instant now) {
    busy_since = now;
    for (auto& [number, held] : leases) {
      if (held.fraction == 0) break;  // they are begun in this order
      held.counted = held.fraction;
    }
  }
  /// Granted nothing until it shows life.
  [[nodiscard]] bool stalled() const { return !expired.empty() || hung; }
  /// It may be granted one more.
  [[nodiscard]] bool has_room(const SchedulerSettings& settings) const {
    if (draining || barred || stalled() || alone || rests) return false;
    if (reserved) return leases.empty();
    if (leases.size() < static_cast<std::size_t>(settings.window_tasks_least)) return true;
    if (leases.size() >= static_cast<std::size_t>(settings.window_tasks_most)) return false;
    double held = 0;  // seconds
    for (const auto& [job, part] : parts) {
      if (part.samples_held == 0) continue;
      if (!part.speed.known()) return false;
      held += static_cast<double>(part.samples_held) / part.speed.rate();
    }
    return held < settings.window_seconds;
  }
  /// Leases begin in their order; those behind what runs wait, and do not stand still.
  [[nodiscard]] Instant next_stall(const SchedulerSettings& settings) const {
    Instant instant = Instant::max();
    for (const auto& [number, held] : leases) {
      if (!held.runs) break;
      instant = std::min(instant, held.advanced + held.stall);
    }
    if (instant != Instant::max()) return instant;
    return std::min(advanced + settings.stall, got_on + settings.preparation);
  }
  /// When something becomes due if nothing more is heard.
  [[nodiscard]] Instant due(const SchedulerSettings& settings) const {
    Instant instant = heard + settings.silence;
    if (!leases.empty()) instant = std::min(instant, next_stall(settings));
    if (rests) instant = std::min(instant, *rests);
    if (hung) instant = std::min(instant, got_on + settings.preparation);
    return instant;
  }
};

}  // namespace tessera::server
