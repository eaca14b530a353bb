#pragma once
#include <vector>

namespace tessera::server {

/// When a job is done, from now, in seconds: what is expected, and an interval that holds the truth
/// four times in five.
struct TimeToFinish {
  double expected = 0;
  double low = 0, high = 0;
};

/// What is known of a job that is being rendered. Work is in the units of WorkLeft.
struct Pace {
  double work = 0;          ///< left, without what is done of running tasks
  double power = 0;         ///< work a second, of all workers that hold leases of it; > 0
  double workers = 1;       ///< how many those are
  double task_seconds = 0;  ///< what a task of its largest pass takes an average worker
  double spread = 0;        ///< of the tiles' costs: standard deviation over mean
  double elapsed = 0;       ///< seconds since its first lease
  /// Σ over workers that came or went since: the square of their share of all.
  double changes = 0;
  double losses = 0;  ///< Σ over workers that went: their share
  /// Other jobs that the workers are shared with, each until it is done. Where there are any,
  /// `power` is that of all workers, as if they worked for this job alone.
  struct Rival {
    double seconds = 0;  ///< that it would take alone
    double weight = 1;
  };
  std::vector<Rival> rivals{};
  double weight = 1;  ///< part of the workers, among the weights of all
};

/// Pure. What is left at the present power; then the tail, in which workers run dry; the interval's
/// width from how the number of workers has changed so far, and from how far single tasks can be
/// off. Its constants are fitted to simulated jobs, and tests/sim holds it to its promise on
/// others.
TimeToFinish time_to_finish(const Pace& pace);

}  // namespace tessera::server
