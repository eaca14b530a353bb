#pragma once
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "server/schedule/scheduler.hpp"
#include "tests/sim/world.hpp"

namespace tessera::sim {

/// A worker process: connects, prepares, renders in order, keeps results until they are
/// acknowledged, comes back.
class Worker {
 public:
  Worker(World& world, std::string identity, double speed, std::string build);

  void start() { connect(); }
  /// The process dies; what it held is gone.
  void crash();
  /// Says bye and ends.
  void leave();
  /// Stopped for so long, as by SIGSTOP.
  void fall_silent(double duration);
  /// The network does not carry what it sends, what it is sent, or both, for so long.
  void cut_off(double duration, bool sends, bool receives);
  [[nodiscard]] bool alive() const { return alive_; }
  [[nodiscard]] const Link& link() const { return link_; }
  [[nodiscard]] const server::WorkerInfo& info() const { return info_; }
  /// It builds a scene.
  [[nodiscard]] bool prepares() const { return preparing_.has_value(); }

  // ---- what arrives from the coordinator ----
  void assigned(const Assigned& order);
  void revoked(const std::vector<LeaseId>& leases);
  /// Accepted, stale or rejected: the result may be forgotten.
  void answered(const LeaseId& lease);
  void disconnected(const Link& link);

 private:
  void connect();
  void heartbeat();
  void go_on();
  void prepare(JobId job);
  void rendered(const Assigned& order, std::uint64_t start);
  void deliver(const SentResult& result);
  /// Calls `what` now, or when the process is let go on.
  void when_awake(std::function<void()> what);

  World& world_;
  server::WorkerInfo info_;
  double speed_;     // samples a second
  double overhead_;  // seconds a task
  double prepare_seconds_;
  bool alive_ = true;
  Instant silent_until_{};
  Partition partition_;
  Link link_;
  std::deque<Assigned> queue_;
  std::optional<Assigned> running_;
  std::uint64_t start_ = 0;  // counts renderings, so that one that was given up is known
  double running_seconds_ = 0;
  Instant running_since_{};
  std::set<JobId> prepared_;
  std::optional<JobId> preparing_;
  std::map<LeaseId, SentResult> outbox_;
};

}  // namespace tessera::sim
