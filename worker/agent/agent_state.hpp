#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/base/clock.hpp"
#include "common/base/limits.hpp"
#include "common/wire/messages.hpp"
#include "worker/agent/renderer.hpp"

/// What a worker holds, owes and says. Sans-IO: no socket, thread or clock; one thread calls it.
namespace tessera::agent {

/// A job by its number and its plan: a coordinator with another data folder counts jobs anew.
using JobKey = std::pair<JobId, Digest>;
using TaskKey = std::pair<JobKey, TaskId>;
using TileBytes = std::shared_ptr<const std::vector<std::byte>>;

struct StateSettings {
  std::size_t outbox_bytes =
      limits::worker_outbox;    ///< no task is begun while results of so many bytes wait
  std::size_t scenes_kept = 2;  ///< built scenes; those with leases are kept in any case
  Duration backoff_first = std::chrono::milliseconds(100);
  Duration backoff_most = std::chrono::seconds(2);
  std::uint64_t jitter = 0;  ///< makes workers come back at different times
};

/// A message on its way out.
struct Outgoing {
  wire::Message message;
  TileBytes body;
};

/// A scene to be fetched and built.
struct PrepareOrder {
  JobKey job;
  std::shared_ptr<const JobPlan> plan;
  std::string blob_url;
  std::string blob_token;
};

/// A task to be rendered now.
struct TaskOrder {
  LeaseId lease;
  JobKey job;
  TaskId task;
  std::shared_ptr<const JobPlan> plan;
  std::shared_ptr<const PreparedScene> scene;
};

class AgentState {
 public:
  explicit AgentState(StateSettings settings = {});

  // ---- the connection ----
  /// Welcomed: the outbox is offered again, everything that was not acknowledged.
  void connected(const wire::Welcome& welcome, Instant now);
  /// The connection has ended, or could not be made. Leases that were not begun are forgotten,
  /// since the coordinator hands them out again; what renders goes on, and its result will be
  /// offered. Gives the wait before the next try: from backoff_first it doubles up to backoff_most,
  /// less up to a half of it by chance.
  Duration disconnected();
  /// A refusal: the program's exit code, or nothing if it is worth trying again later.
  static std::optional<int> refused(const wire::Refused& refused);
  /// Any message after the welcome. `bye` is the caller's to see.
  void said(const wire::Message& message, Instant now);
  [[nodiscard]] bool is_connected() const { return connected_; }

  // ---- time ----
  /// The heartbeat, if it is due.
  void tick(Instant now);
  [[nodiscard]] Instant next_beat() const { return next_beat_; }

  // ---- what is to be done; each is given out once ----
  std::vector<Outgoing> take_outgoing();
  /// Leases whose rendering is to be stopped.
  std::vector<LeaseId> take_stops();
  /// The next job whose scene is wanted, if none is being prepared.
  std::optional<PrepareOrder> take_prepare();
  /// Scenes that were let go of, take_prepare()'s among them, to be freed where that holds up
  /// nobody: it takes long.
  std::vector<std::shared_ptr<const PreparedScene>> take_let_go();
  /// True if the scene being prepared is wanted no more.
  [[nodiscard]] bool prepare_unwanted() const;
  /// The next task in the order assigned whose scene is there; nothing while the outbox is full.
  std::optional<TaskOrder> next_task();

  // ---- what was done ----
  void prepare_progress(double fraction) { prepare_fraction_ = fraction; }
  void cache_is(const wire::CacheUse& use) { cache_ = use; }
  /// It also takes the place of those of its bundle that serve fewer jobs: the tasks that render
  /// from one are the last to hold it.
  void prepared(std::shared_ptr<const PreparedScene> scene);
  /// Given up because it was unwanted; or wanted again meanwhile: then it is begun anew.
  void prepare_stopped();
  void prepare_failed(const std::string& code, const std::string& reason);
  void task_progress(const LeaseId& lease, double fraction);
  /// `stats` without image; the lease, job and task are put into the result here.
  void task_done(const LeaseId& lease, const RenderedTile& stats, TileBytes bytes);
  void task_failed(const LeaseId& lease, const std::string& code, const std::string& reason);
  /// It was stopped as asked.
  void task_stopped(const LeaseId& lease);

  // ---- leaving ----
  /// Begins nothing more; what was not begun is given back by the bye.
  void drain(const std::string& reason);
  [[nodiscard]] bool draining() const { return draining_; }
  /// Draining, nothing renders, and every result is acknowledged.
  [[nodiscard]] bool finished() const { return draining_ && running_.empty() && outbox_.empty(); }

  // ---- looking ----
  [[nodiscard]] std::size_t queued() const { return queued_.size(); }
  [[nodiscard]] std::size_t running() const { return running_.size(); }
  [[nodiscard]] std::size_t outbox() const { return outbox_.size(); }
  [[nodiscard]] std::size_t outbox_bytes() const { return outbox_bytes_; }

 private:
  struct Job {
    std::shared_ptr<const JobPlan> plan;
    std::shared_ptr<const PreparedScene> scene;
    bool announced =
        false;  ///< preparing, or ready once the scene is there, was said on this connection
    std::size_t queued = 0, running = 0;  ///< leases
    std::uint64_t used = 0;               ///< grows; the least was used longest ago

    [[nodiscard]] bool idle() const { return queued == 0 && running == 0; }
  };
  struct Held {
    LeaseId lease;
    JobKey job;
    TaskId task;
    double fraction = 0;
    bool of_this_connection = true;
    bool revoked = false;
  };
  struct Owed {
    wire::Result result;
    TileBytes bytes;
  };

  void say(wire::Message message, TileBytes body = nullptr);
  void enqueue(const Held& held);
  Held dequeue(std::map<std::uint64_t, Held>::iterator at);
  void drop_queued();
  void assigned(const wire::Assign& assign);
  void revoked(const wire::Revoke& revoke);
  void settled(const LeaseId& lease, bool task_closed);
  void say_ready(const JobKey& key, Job& job);
  void release_parked(const TaskKey& task, bool drop);
  void end_running(const LeaseId& lease);
  [[nodiscard]] bool wanted(const JobKey& key) const;
  /// Those whose scene is of the same bundle, but was built for jobs that look at less.
  [[nodiscard]] std::vector<Job*> jobs_with_less_than(const JobPlan& plan);
  /// Before a scene is built that keeps more: lets go of those whose place it will take and that no
  /// lease needs, so that there is memory for one.
  void make_room_for(const JobPlan& plan);
  void trim_scenes();
  void let_go(Job& job);
  void fail_job(const JobKey& key, const std::string& code, const std::string& reason);

  StateSettings settings_;
  bool connected_ = false;
  bool draining_ = false;
  int attempts_ = 0;
  std::uint64_t jitter_ = 0;
  wire::Welcome welcome_;
  Instant next_beat_{};
  std::uint64_t clock_ = 0;  ///< numbers what is to stay in order

  std::map<JobKey, Job> jobs_;
  std::optional<JobKey> preparing_;
  double prepare_fraction_ = 0;
  std::optional<wire::CacheUse> cache_;
  std::map<std::uint64_t, Held> queued_;  ///< in the order assigned
  std::map<LeaseId, std::uint64_t> queued_at_;
  std::map<LeaseId, Held> running_;
  std::set<TaskKey> under_way_;  ///< tasks that render or wait in the outbox
  std::map<TaskKey, std::vector<Held>>
      parked_;  ///< new leases of such tasks: the result that is there answers them
  std::map<std::uint64_t, Owed> outbox_;  ///< in the order in which they were done
  std::map<LeaseId, std::uint64_t> outbox_at_;
  std::size_t outbox_bytes_ = 0;

  std::vector<Outgoing> outgoing_;
  std::vector<LeaseId> stops_;
  std::vector<std::shared_ptr<const PreparedScene>> let_go_;
};

}  // namespace tessera::agent
