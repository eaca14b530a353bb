#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "common/job/job_spec.hpp"
#include "common/job/task.hpp"
#include "server/schedule/frame_tasks.hpp"

namespace tessera::server {

/// The tasks of one job. Frames are begun in order, the next one when the earlier ones have nothing
/// to give; a finished frame takes one bit.
class TaskTable {
 public:
  TaskTable(std::shared_ptr<const JobPlan> plan, std::uint32_t passes_ahead);

  using State = FrameTasks::State;
  [[nodiscard]] const JobPlan& plan() const { return *plan_; }
  /// The task must be one of the plan's, here and below.
  [[nodiscard]] State state(const TaskId& task) const;
  /// Within the limit of passes ahead of its tile's fold.
  [[nodiscard]] bool within(const TaskId& task) const;
  /// Pixels × samples of the pass.
  [[nodiscard]] std::int64_t samples(const TaskId& task) const;

  /// The next task to hand out.
  std::optional<TaskId> peek();
  /// Passes [0, passes) are handed out, those of later ones when this says so; all unless it does.
  /// It never says fewer, but for the first time.
  void offer_passes(std::uint32_t passes);
  [[nodiscard]] std::uint32_t offered() const { return offered_; }
  /// The job is done with so many passes, of which all are offered and no later one is taken or
  /// closed. What was finished by this. Jobs of one frame alone. O(tiles).
  enum class Folded { nothing, tile, frame, job };
  Folded cut(std::uint32_t passes);
  /// So many passes of every tile are folded. Jobs of one frame alone.
  [[nodiscard]] bool all_folded(std::uint32_t passes);
  /// How many there are.
  [[nodiscard]] std::uint32_t passes() const { return passes_; }
  [[nodiscard]] std::int64_t tasks() const {
    return std::int64_t{plan_->grid.count()} * passes_ * frames_;
  }
  /// Tiles that touch this rectangle come first in every frame, as FrameTasks says. O(tiles log
  /// tiles) for each frame that has begun.
  void set_focus(const std::optional<Rect>& focus);
  /// False if it is not open.
  bool take(const TaskId& task);
  void reopen(const TaskId& task);
  /// False if it was closed before.
  bool close(const TaskId& task);
  /// What was finished by this fold.
  Folded fold(std::int32_t frame, std::uint32_t tile, std::uint32_t passes);

  [[nodiscard]] std::int64_t closed() const { return closed_; }
  [[nodiscard]] std::int64_t samples_closed() const { return samples_closed_; }
  [[nodiscard]] std::int64_t samples() const;

 private:
  [[nodiscard]] std::uint32_t index_of(std::int32_t frame) const;
  [[nodiscard]] std::int32_t number_of(std::uint32_t index) const;
  FrameTasks& begun(std::uint32_t index);
  Folded end_frame(std::uint32_t index);

  std::shared_ptr<const JobPlan> plan_;
  std::shared_ptr<const TileRanks> ranks_;
  std::optional<FocusTiles> focus_;
  std::uint32_t passes_ahead_;
  std::uint32_t passes_, offered_;
  std::uint32_t frames_;
  std::map<std::uint32_t, FrameTasks> begun_;  // by index, finished ones left out
  std::set<std::uint32_t> ready_;              // of those, the ones that may have something to give
  std::vector<bool> finished_;                 // by index
  std::uint32_t frames_finished_ = 0;
  std::uint32_t next_ = 0;  // frames below have been begun by peek
  std::int64_t closed_ = 0, samples_closed_ = 0;
};

}  // namespace tessera::server
