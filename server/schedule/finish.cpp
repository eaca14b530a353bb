#include "server/schedule/finish.hpp"

#include <algorithm>
#include <cmath>

namespace tessera::server {
namespace {

// Fitted to simulated jobs (tests/sim/eta.cpp).
constexpr double tail_tasks = 0.41;  // seconds of the tail, in tasks of tiles that cost the same
constexpr double tail_low = 0.5, tail_high = 0.8;  // by how much of itself it may be off
constexpr double tail_doubt = 0.3;                 // … and more when it has begun
constexpr double loss = 0.25;                      // of a task, what goes with a worker that goes
constexpr double chance = 0.03;     // of a change of the number of workers where none was seen
constexpr double saturation = 4.5;  // workers that come make up for those that go
constexpr double change_low = 1.15, change_high = 1.9;
constexpr double sharing_low = 0.14, sharing_high = 0.5;
constexpr double tail_shared_most = 4;
constexpr double error = 0.005, error_of_workers = 0.03, error_of_time = 0.05;

/// The seconds from where workers begin to run dry to the end. It grows with the costliest tiles,
/// the more so the more workers wait for them.
double tail_of(const Pace& pace, double workers) {
  const double steep = 2.35 * std::min(1.0, std::log(workers + 1) / 2.9);
  return pace.task_seconds * tail_tasks * std::exp(steep * std::min(1.2, pace.spread));
}

/// Seconds until a job is done that takes `alone` by itself, if everyone gets the part of all that
/// is his weight among those that are not done yet.
double shared(double alone, const Pace& pace) {
  std::vector<Pace::Rival> rivals = pace.rivals;
  const auto turn = [](const Pace::Rival& rival) { return rival.seconds / rival.weight; };
  std::sort(rivals.begin(), rivals.end(),
            [&](const auto& a, const auto& b) { return turn(a) < turn(b); });
  double weights = pace.weight;
  for (const Pace::Rival& rival : rivals) weights += rival.weight;
  const double own = alone / pace.weight;
  double time = 0, before = 0;
  for (const Pace::Rival& rival : rivals) {
    if (turn(rival) >= own) break;
    time += (turn(rival) - before) * weights;
    before = turn(rival);
    weights -= rival.weight;
  }
  return time + (own - before) * weights;
}

/// Seconds at the present power. Workers that go take with them what they had begun.
double flow_of(const Pace& pace, double elapsed) {
  const double lost = std::min(2.0, loss * pace.losses / elapsed * pace.task_seconds);
  const double alone = pace.work / pace.power * (lost > 1e-6 ? std::expm1(lost) / lost : 1);
  return pace.rivals.empty() ? alone : shared(alone, pace);
}

}  // namespace

TimeToFinish time_to_finish(const Pace& pace) {
  const double workers = std::max(1.0, pace.workers);
  const double elapsed = std::max(1.0, pace.elapsed);
  const double flow = flow_of(pace, elapsed);
  // How many times as long it takes because of others, of whom less is known: what they cost, and
  // who comes next. The last tasks wait behind theirs.
  const bool alone = pace.rivals.empty() || pace.work <= 0;
  const double slower = alone ? 1 : std::max(1.0, flow * pace.power / pace.work);
  const double others = 1 - 1 / slower;
  const double tail = tail_of(pace, workers) * std::min(tail_shared_most, (1 + slower) / 2);
  // The mean of a random walk over `flow` seconds has a third of the variance at its end.
  const double walk = (pace.changes + chance / (workers * workers)) / elapsed * flow / 3;
  const double drift = std::sqrt(walk / (1 + saturation * walk));
  const double measured = error + error_of_workers / std::sqrt(workers) +
                          error_of_time * std::sqrt(flow / elapsed / workers);
  const double begun = tail > 0 ? tail_doubt * std::exp(-flow / tail) : 0;
  TimeToFinish time;
  time.expected = flow + tail;
  time.low = time.expected -
             std::hypot(flow * -std::expm1(-(measured + sharing_low * others + change_low * drift)),
                        tail * (tail_low + 0.6 * begun + 0.3 * others));
  time.high = time.expected +
              std::hypot(flow * std::expm1(measured + sharing_high * others + change_high * drift),
                         tail * (tail_high + 2 * begun + 1.5 * others));
  return time;
}

}  // namespace tessera::server
