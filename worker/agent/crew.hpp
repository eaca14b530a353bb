#pragma once
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

#include "common/base/clock.hpp"
#include "worker/agent/agent_state.hpp"
#include "worker/agent/renderer.hpp"

/// The threads that drive the renderer.
namespace tessera::agent {

/// How a task ended. `bytes` is the tile as EXR.
struct TaskEnd {
  enum class What { done, stopped, failed };
  LeaseId lease;
  What what = What::stopped;
  RenderedTile stats;  ///< without its image
  TileBytes bytes;
  std::string code;  ///< of a failure
  std::string reason;
};

/// How well the crew was kept busy: gaps are the times when nothing rendered between one task's end
/// and the next one's begin.
struct CrewStats {
  std::int64_t tasks = 0;
  std::int64_t gaps = 0;
  double gap_seconds = 0;
  double gap_most = 0;
};

/// How many tasks of so many samples are rendered at once: one thread for each where they are
/// small, and two where they are large, so that the end of one, which does not feed all threads,
/// overlaps with the next.
int tasks_at_once(std::int64_t samples, int threads);

/// Renders what it is given, in order, several at once where they are small, all by the renderer's
/// threads. Another thread encodes tiles, so that the next task begins at once. Functions are
/// thread-safe; callbacks come from the crew's threads.
class Crew {
 public:
  using OnEnd = std::function<void(TaskEnd)>;
  using OnProgress = std::function<void(const LeaseId&, double)>;
  Crew(TaskRenderer& renderer, OnEnd on_end, OnProgress on_progress);
  /// Stops what renders, and waits.
  ~Crew();
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  /// True if another task should be given now: one more than can begin waits, so that no lane is
  /// ever idle for the want of one.
  [[nodiscard]] bool wants_more() const;
  void give(TaskOrder order);
  /// Stops a task that renders or waits here; it ends as stopped.
  void stop(const LeaseId& lease);
  void stop_all();
  [[nodiscard]] CrewStats stats() const;

 private:
  struct Encoding {
    LeaseId lease;
    RenderedTile tile;
  };
  void lane();
  void encoder();
  void render(const TaskOrder& order, const std::stop_token& stop);
  [[nodiscard]] bool may_begin() const;
  void note_begin(Instant now);
  void note_end(Instant now);

  TaskRenderer& renderer_;
  OnEnd on_end_;
  OnProgress on_progress_;
  mutable std::mutex mutex_;
  std::condition_variable wake_lanes_, wake_encoder_;
  bool ending_ = false;
  std::deque<TaskOrder> waiting_;
  std::map<LeaseId, std::stop_source> stops_;  ///< of all that wait or render
  int active_ = 0;
  int at_once_ = 1;  ///< by the size of the last task given
  std::deque<Encoding> encoding_;
  bool encoder_ending_ = false;
  CrewStats stats_;
  Instant idle_since_{};
  std::vector<std::thread> lanes_;
  std::thread encoder_thread_;
};

}  // namespace tessera::agent
