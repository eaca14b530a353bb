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
/// to give; a finished frame takes one bit, and its passes if they are fewer than the plan's.
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
  /// Passes [0, passes) of each frame are handed out, later ones when the next function says so;
  /// all unless this is called, before anything else.
  void offer_first(std::uint32_t passes);
  /// … of this frame: more than before.
  void offer_passes(std::int32_t frame, std::uint32_t passes);
  [[nodiscard]] std::uint32_t offered(std::int32_t frame) const;
  /// The frame is done with so many passes, at least 1 and fewer than it had; no later one is taken
  /// or closed.
  /// What was finished by this. O(tiles).
  enum class Folded { nothing, tile, frame, job };
  Folded cut(std::int32_t frame, std::uint32_t passes);
  [[nodiscard]] bool is_cut(std::int32_t frame) const;
  /// So many passes of every tile of the frame are folded.
  [[nodiscard]] bool all_folded(std::int32_t frame, std::uint32_t passes);
  /// How many there are of a frame that was not cut, and of this one.
  [[nodiscard]] std::uint32_t passes() const { return plan_->passes.count(); }
  [[nodiscard]] std::uint32_t passes(std::int32_t frame) const {
    return passes_of(index_of(frame));
  }
  /// Samples of each pixel that the frame has when it is done.
  [[nodiscard]] std::int64_t frame_samples(std::int32_t frame) const {
    return samples_to(passes(frame));
  }
  /// The frame, which is not finished, is expected to end with so many samples of each pixel, as
  /// far as its plan goes.
  void expect(std::int32_t frame, double samples);
  /// If frames of which nothing is expected end as the others do on average, those that are
  /// finished too: passes of one, and the samples of a pixel that all together are spared. O(frames
  /// that have begun).
  [[nodiscard]] std::uint32_t expected_passes() const;
  [[nodiscard]] double spared() const;
  [[nodiscard]] std::int64_t tasks() const {
    return std::int64_t{plan_->grid.count()} * (std::int64_t{passes()} * frames_ - passes_cut_);
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
  [[nodiscard]] std::uint32_t passes_of(std::uint32_t index) const {
    const auto cut = cuts_.find(index);
    return cut == cuts_.end() ? passes() : cut->second;
  }
  [[nodiscard]] std::int64_t samples_to(std::uint32_t passes) const {
    return passes == 0 ? 0 : plan_->passes.pass(passes - 1).end();
  }
  /// Of the frames that are finished or of which an end is expected; the plan's while none is.
  [[nodiscard]] double mean_samples() const;
  FrameTasks& begun(std::uint32_t index);
  Folded end_frame(std::uint32_t index);

  std::shared_ptr<const JobPlan> plan_;
  std::shared_ptr<const TileRanks> ranks_;
  std::optional<FocusTiles> focus_;
  std::uint32_t passes_ahead_;
  std::uint32_t first_offer_;  // passes of each frame that begins
  std::uint32_t frames_;
  std::map<std::uint32_t, std::uint32_t> cuts_;    // passes of frames that end sooner, by index
  std::int64_t passes_cut_ = 0, samples_cut_ = 0;  // that these do without, of each pixel
  std::map<std::uint32_t, double> expected_;       // samples with which frames are to end, by index
  std::map<std::uint32_t, FrameTasks> begun_;      // by index, finished ones left out
  std::set<std::uint32_t> ready_;  // of those, the ones that may have something to give
  std::vector<bool> finished_;     // by index
  std::uint32_t frames_finished_ = 0;
  std::int64_t samples_finished_ = 0;  // of a pixel, over all of those
  std::uint32_t next_ = 0;             // frames below have been begun by peek
  std::int64_t closed_ = 0, samples_closed_ = 0;
};

}  // namespace tessera::server
