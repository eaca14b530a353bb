#include "server/schedule/task_table.hpp"

#include <cassert>
#include <utility>

namespace tessera::server {

TaskTable::TaskTable(std::shared_ptr<const JobPlan> plan, std::uint32_t passes_ahead)
    : plan_(std::move(plan)),
      ranks_(std::make_shared<const TileRanks>(plan_->grid, plan_->spec.order)),
      passes_ahead_(passes_ahead),
      passes_(plan_->passes.count()),
      offered_(passes_),
      frames_(plan_->spec.frames.count()),
      finished_(frames_) {
  if (plan_->spec.focus) focus_.emplace(plan_->grid, *plan_->spec.focus);
}

std::uint32_t TaskTable::index_of(std::int32_t frame) const {
  return plan_->spec.frames.index(frame);
}

std::int32_t TaskTable::number_of(std::uint32_t index) const {
  return plan_->spec.frames.number(index);
}

FrameTasks& TaskTable::begun(std::uint32_t index) {
  assert(!finished_[index]);
  const auto [place, fresh] = begun_.try_emplace(index, ranks_, passes_, passes_ahead_);
  if (fresh) {
    if (offered_ < passes_) place->second.offer_passes(offered_);
    if (focus_) place->second.set_focus(focus_);
    ready_.insert(index);
  }
  return place->second;
}

TaskTable::State TaskTable::state(const TaskId& task) const {
  const std::uint32_t index = index_of(task.frame);
  if (finished_[index]) return State::closed;
  const auto frame = begun_.find(index);
  return frame == begun_.end() ? State::open : frame->second.state({task.pass, task.tile});
}

bool TaskTable::within(const TaskId& task) const {
  const auto frame = begun_.find(index_of(task.frame));
  return frame != begun_.end() ? frame->second.within({task.pass, task.tile})
                               : task.pass < passes_ahead_;
}

std::int64_t TaskTable::samples(const TaskId& task) const {
  return plan_->grid.tile(task.tile).pixels() * plan_->passes.pass(task.pass).count;
}

std::int64_t TaskTable::samples() const {
  return plan_->grid.window().pixels() * plan_->passes.pass(passes_ - 1).end() * frames_;
}

std::optional<TaskId> TaskTable::peek() {
  while (true) {
    while (!ready_.empty()) {
      const std::uint32_t index = *ready_.begin();
      if (const auto task = begun_.at(index).peek())
        return TaskId{number_of(index), task->tile, task->pass};
      ready_.erase(ready_.begin());
    }
    while (next_ < frames_ && (finished_[next_] || begun_.contains(next_))) ++next_;
    if (next_ == frames_) return std::nullopt;
    begun(next_++);
  }
}

void TaskTable::offer_passes(std::uint32_t passes) {
  offered_ = std::min(passes, passes_);
  for (auto& [index, frame] : begun_) {
    frame.offer_passes(offered_);
    ready_.insert(index);
  }
}

bool TaskTable::all_folded(std::uint32_t passes) {
  return finished_[0] || begun(0).all_folded(passes);
}

TaskTable::Folded TaskTable::cut(std::uint32_t passes) {
  passes_ = passes;
  offered_ = std::min(offered_, passes);
  FrameTasks& frame = begun(0);
  frame.cut(passes);
  return frame.finished() ? end_frame(0) : Folded::nothing;
}

TaskTable::Folded TaskTable::end_frame(std::uint32_t index) {
  begun_.erase(index);
  ready_.erase(index);
  finished_[index] = true;
  return ++frames_finished_ == frames_ ? Folded::job : Folded::frame;
}

void TaskTable::set_focus(const std::optional<Rect>& focus) {
  focus_.reset();
  if (focus) focus_.emplace(plan_->grid, *focus);
  for (auto& [index, frame] : begun_) frame.set_focus(focus_);
}

bool TaskTable::take(const TaskId& task) {
  const std::uint32_t index = index_of(task.frame);
  return !finished_[index] && begun(index).take({task.pass, task.tile});
}

void TaskTable::reopen(const TaskId& task) {
  const std::uint32_t index = index_of(task.frame);
  begun(index).reopen({task.pass, task.tile});
  ready_.insert(index);
}

bool TaskTable::close(const TaskId& task) {
  const std::uint32_t index = index_of(task.frame);
  if (finished_[index] || !begun(index).close({task.pass, task.tile})) return false;
  ++closed_;
  samples_closed_ += samples(task);
  return true;
}

TaskTable::Folded TaskTable::fold(std::int32_t frame, std::uint32_t tile, std::uint32_t passes) {
  const std::uint32_t index = index_of(frame);
  if (finished_[index]) return Folded::nothing;
  FrameTasks& tasks = begun(index);
  const std::uint32_t before = tasks.folded(tile);
  for (std::uint32_t pass = before; pass < passes && pass < passes_; ++pass) {
    if (tasks.state({pass, tile}) == State::closed) continue;
    samples_closed_ += samples({frame, tile, pass});  // folded from what is older than the journal
  }
  closed_ += tasks.fold(tile, passes);
  if (tasks.folded(tile) == before) return Folded::nothing;
  if (!tasks.finished()) {
    ready_.insert(index);
    return Folded::tile;
  }
  return end_frame(index);
}

}  // namespace tessera::server
