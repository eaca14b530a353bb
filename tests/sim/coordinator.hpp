#pragma once
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/film/film_tile.hpp"
#include "server/schedule/scheduler.hpp"
#include "tests/sim/world.hpp"

namespace tessera::sim {

/// The real scheduler and the real fold, with a disk and a pool that take their time. Checks the
/// scheduler's rules at every grant. A restart loses all that is not on the disk.
class Coordinator {
 public:
  explicit Coordinator(World& world) : world_(world) {}

  [[nodiscard]] bool up() const { return scheduler_ != nullptr; }
  void start();
  void kill();
  void submit(JobId job);
  void cancel(JobId job);
  void pause(JobId job, double duration);
  [[nodiscard]] bool all_ended() const;
  /// Once a second: no worker idles while a task waits, and nobody silent is kept.
  void look_around();

  // ---- what arrives from workers ----
  void hello(const Link& link, const server::WorkerInfo& info);
  void preparing(const Link& link, JobId job);
  void ready(const Link& link, JobId job);
  void progress(const Link& link, const std::vector<std::pair<LeaseId, double>>& running);
  void failed(const Link& link, JobId job, const LeaseId& lease);
  void result(const Link& link, const SentResult& sent);
  void bye(const Link& link);
  void closed(const Link& link);

 private:
  struct Film {
    std::map<std::pair<std::int32_t, std::uint32_t>, server::FilmTile> tiles;
    std::set<std::pair<std::int32_t, std::uint32_t>> folding;
  };
  struct Arrived {
    Link link;
    server::WorkerId worker = 0;
    SentResult sent;
  };
  struct Lease {
    server::WorkerId worker = 0;
    JobId job = 0;
    TaskId task;
  };

  void apply(const server::Actions& actions);
  void granted(const server::GrantLease& grant);
  void release(const LeaseId& lease);
  void release_all(server::WorkerId worker);
  void left(const Link& link, bool clean);
  /// False if the connection is not one that this life of the coordinator knows.
  bool heard(const Link& link);
  void arm();
  void later(double delay, std::function<void()> what);
  void restore(JobId id);
  void commit();
  void durable(const Arrived& arrived);
  void fold_on(JobId job, std::int32_t frame, std::uint32_t tile);
  /// It has a task that could be leased and is not; with `plain`, one that is no suspect.
  [[nodiscard]] bool waits(JobId id, bool plain) const;
  void check_copy(const server::GrantLease& grant, const std::string& what) const;
  [[nodiscard]] bool quarantined(server::WorkerId worker) const;
  [[nodiscard]] std::string describe(server::WorkerId worker,
                                     const std::vector<JobId>& waiting) const;
  [[nodiscard]] std::uint32_t folded(JobId job, const TaskId& task) const;

  World& world_;
  std::unique_ptr<server::Scheduler> scheduler_;
  std::uint64_t life_ = 0;  // of the process: what was begun in an earlier one does not go on
  std::optional<Instant> armed_;
  std::map<server::WorkerId, Link> links_;
  std::map<server::WorkerId, Instant> last_byte_;
  std::map<server::WorkerId, std::set<LeaseId>> held_;
  std::map<server::WorkerId, int> idle_looks_;
  std::map<server::WorkerId, Instant> excused_;  // resting after errors
  std::map<LeaseId, Lease> leases_;
  std::map<std::pair<JobId, TaskId>, std::set<LeaseId>> out_;
  std::set<std::pair<JobId, TaskId>> doubted_;  // came back without a result: may be suspects
  std::set<std::pair<JobId, TaskId>> arrived_;  // being decoded or journaled
  std::map<JobId, Film> films_;
  std::set<JobId> paused_;
  std::map<JobId, Digest> builds_;
  std::vector<Arrived> journal_;  // decoded, not yet synced
  bool syncing_ = false;
};

}  // namespace tessera::sim
