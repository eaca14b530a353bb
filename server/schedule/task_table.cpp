#include "server/schedule/task_table.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "server/schedule/noise_stop.hpp"

namespace tessera::server {

TaskTable::TaskTable(std::shared_ptr<const JobPlan> plan, std::uint32_t passes_ahead)
    : plan_(std::move(plan)),
      ranks_(std::make_shared<const TileRanks>(plan_->grid, plan_->spec.order)),
      passes_ahead_(passes_ahead),
      first_offer_(plan_->passes.count()),
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
  const auto [place, fresh] = begun_.try_emplace(index, ranks_, passes_of(index), passes_ahead_);
  if (fresh) {
    if (first_offer_ < passes_of(index)) place->second.offer_passes(first_offer_);
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
  return plan_->grid.window().pixels() * (plan_->passes.samples() * frames_ - samples_cut_);
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

void TaskTable::offer_first(std::uint32_t passes) {
  assert(begun_.empty());
  first_offer_ = std::min(passes, this->passes());
}

void TaskTable::offer_passes(std::int32_t frame, std::uint32_t passes) {
  const std::uint32_t index = index_of(frame);
  if (finished_[index]) return;
  begun(index).offer_passes(passes);
  ready_.insert(index);
}

std::uint32_t TaskTable::offered(std::int32_t frame) const {
  const std::uint32_t index = index_of(frame);
  if (finished_[index]) return passes_of(index);
  const auto begun = begun_.find(index);
  return begun == begun_.end() ? std::min(first_offer_, passes_of(index)) : begun->second.offered();
}

bool TaskTable::all_folded(std::int32_t frame, std::uint32_t passes) {
  const std::uint32_t index = index_of(frame);
  return finished_[index] || begun(index).all_folded(passes);
}

bool TaskTable::is_cut(std::int32_t frame) const { return cuts_.contains(index_of(frame)); }

TaskTable::Folded TaskTable::cut(std::int32_t frame, std::uint32_t passes) {
  const std::uint32_t index = index_of(frame), before = passes_of(index);
  assert(passes >= 1 && passes < before);
  if (finished_[index]) return Folded::nothing;
  passes_cut_ += before - passes;
  samples_cut_ += samples_to(before) - samples_to(passes);
  cuts_[index] = passes;
  const auto begun = begun_.find(index);
  if (begun == begun_.end()) return Folded::nothing;
  begun->second.cut(passes);
  return begun->second.finished() ? end_frame(index) : Folded::nothing;
}

double TaskTable::mean_samples() const {
  const std::size_t known = frames_finished_ + expected_.size();
  if (known == 0) return static_cast<double>(plan_->passes.samples());
  auto sum = static_cast<double>(samples_finished_);
  for (const auto& [index, samples] : expected_) sum += samples;
  return sum / static_cast<double>(known);
}

void TaskTable::expect(std::int32_t frame, double samples) {
  const std::uint32_t index = index_of(frame);
  const auto most = static_cast<double>(samples_to(passes_of(index)));
  if (!finished_[index]) expected_[index] = std::min(samples, most);
}

std::uint32_t TaskTable::expected_passes() const {
  if (frames_ == 1) return passes_of(0);
  const auto mean = static_cast<std::int64_t>(std::ceil(mean_samples()));
  return std::min(passes_within(plan_->passes, mean - 1) + 1, passes());
}

double TaskTable::spared() const {
  if (frames_finished_ == 0 && expected_.empty()) return 0;
  const double mean = mean_samples();
  const auto beyond = [](std::int64_t planned, double expected) {
    return std::max(0.0, static_cast<double>(planned) - expected);
  };
  const std::size_t to_come = frames_ - frames_finished_ - begun_.size();
  double samples = static_cast<double>(to_come) * beyond(plan_->passes.samples(), mean);
  for (const auto& [index, frame] : begun_) {
    const auto known = expected_.find(index);
    const double end = known == expected_.end() ? mean : known->second;
    samples += beyond(samples_to(passes_of(index)),
                      std::max(end, static_cast<double>(samples_to(frame.offered()))));
  }
  return samples;
}

TaskTable::Folded TaskTable::end_frame(std::uint32_t index) {
  begun_.erase(index);
  expected_.erase(index);
  ready_.erase(index);
  finished_[index] = true;
  samples_finished_ += samples_to(passes_of(index));
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
  for (std::uint32_t pass = before; pass < passes && pass < passes_of(index); ++pass) {
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
