#include "server/schedule/frame_tasks.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <functional>
#include <utility>

namespace tessera::server {
namespace {

constexpr std::uint32_t mask_bits = 32;
constexpr int pass_shift = 32, kind_shift = 62;
constexpr std::uint64_t pass_mask = (std::uint64_t{1} << (kind_shift - pass_shift)) - 1;
// So many tiles at most are swept in one call while the queue has something else to give.
constexpr std::uint32_t sweep_most = 1024;

std::uint32_t shifted(std::uint32_t mask, std::uint32_t by) {
  return by < mask_bits ? mask >> by : 0;
}

/// Of a tile outside the focus. Kinds: the first pass of a focus (0), the first pass, other passes
/// of a focus, other passes.
constexpr std::uint64_t plain_key(std::uint32_t pass, std::uint32_t rank) {
  const std::uint64_t kind = pass == 0 ? 1 : 3;
  return kind << kind_shift | std::uint64_t{pass} << pass_shift | rank;
}

}  // namespace

FrameTasks::FrameTasks(std::shared_ptr<const TileRanks> ranks, std::uint32_t passes,
                       std::uint32_t ahead)
    : ranks_(std::move(ranks)),
      tiles_(ranks_->count()),
      passes_(passes),
      ahead_(ahead),
      offered_(passes),
      sweep_from_(0),
      chunks_((tiles_ + chunk_tiles - 1) / chunk_tiles) {
  assert(ahead >= 1 && ahead <= mask_bits);
}

FrameTasks::Key FrameTasks::key_of(const FrameTask& task) const {
  const Key plain = plain_key(task.pass, ranks_->rank(task.tile));
  return focus_ && focus_->contains(task.tile) ? plain - (Key{1} << kind_shift) : plain;
}

FrameTask FrameTasks::task_of(Key key) const {
  return {static_cast<std::uint32_t>(key >> pass_shift & pass_mask),
          ranks_->tile(static_cast<std::uint32_t>(key))};
}

void FrameTasks::push(const FrameTask& task) {
  queue_.push_back(key_of(task));
  std::push_heap(queue_.begin(), queue_.end(), std::greater<>());
}

void FrameTasks::pop() {
  std::pop_heap(queue_.begin(), queue_.end(), std::greater<>());
  queue_.pop_back();
}

FrameTasks::Tile& FrameTasks::tile(std::uint32_t index) {
  assert(index < tiles_);
  auto& chunk = chunks_[index / chunk_tiles];
  if (!chunk) chunk = std::make_unique<Chunk>();
  return (*chunk)[index % chunk_tiles];
}

const FrameTasks::Tile& FrameTasks::tile(std::uint32_t index) const {
  static const Tile untouched;
  const auto& chunk = chunks_[index / chunk_tiles];
  return chunk ? (*chunk)[index % chunk_tiles] : untouched;
}

FrameTasks::State FrameTasks::state(const FrameTask& task) const {
  const Tile& t = tile(task.tile);
  if (task.pass < t.base) return State::closed;
  const std::uint32_t bit = task.pass - t.base;
  if (bit >= mask_bits) return State::open;
  if (t.closed >> bit & 1) return State::closed;
  return t.taken >> bit & 1 ? State::taken : State::open;
}

std::optional<FrameTask> FrameTasks::peek() {
  std::uint32_t swept = 0;
  while (true) {
    while (!queue_.empty() && state(task_of(queue_.front())) != State::open) pop();
    if (!queue_.empty()) {
      const Key least = plain_key(sweep_from_, sweep_);  // that the sweep may bring: no focus
      if (queue_.front() < least || sweep_ == tiles_ || swept >= sweep_most)
        return task_of(queue_.front());
    }
    if (sweep_ == tiles_) return std::nullopt;
    const std::uint32_t next = ranks_->tile(sweep_++);
    offer(next, tile(next));
    ++swept;
  }
}

void FrameTasks::offer_passes(std::uint32_t passes) {
  if (sweep_ == tiles_) sweep_from_ = offered_;
  offered_ = std::min(passes, passes_);
  sweep_ = 0;
  if (focus_) focus_->for_each([this](std::uint32_t index) { offer(index, tile(index)); });
}

void FrameTasks::cut(std::uint32_t passes) {
  passes_ = passes;
  offered_ = std::min(offered_, passes);
  tiles_finished_ = 0;
  for (std::uint32_t index = 0; index < tiles_; ++index)
    if (folded(index) >= passes_) ++tiles_finished_;
}

void FrameTasks::set_focus(const std::optional<FocusTiles>& focus) {
  focus_ = focus;
  if (focus_) focus_->for_each([this](std::uint32_t index) { offer(index, tile(index)); });
  std::erase_if(queue_, [this](Key key) { return state(task_of(key)) != State::open; });
  for (Key& key : queue_) key = key_of(task_of(key));
  std::make_heap(queue_.begin(), queue_.end(), std::greater<>());
}

bool FrameTasks::take(const FrameTask& task) {
  Tile& t = tile(task.tile);
  if (state(task) != State::open || task.pass - t.base >= mask_bits) return false;
  t.taken |= 1U << (task.pass - t.base);
  return true;
}

void FrameTasks::reopen(const FrameTask& task) {
  assert(state(task) == State::taken);
  Tile& t = tile(task.tile);
  t.taken &= ~(1U << (task.pass - t.base));
  if (task.pass < t.offered) push(task);
}

bool FrameTasks::close(const FrameTask& task) {
  Tile& t = tile(task.tile);
  if (task.pass >= passes_ || state(task) == State::closed || task.pass - t.base >= mask_bits)
    return false;
  const std::uint32_t bit = 1U << (task.pass - t.base);
  t.closed |= bit;
  t.taken &= ~bit;
  advance_base(t);
  return true;
}

std::uint32_t FrameTasks::fold(std::uint32_t index, std::uint32_t passes) {
  Tile& t = tile(index);
  passes = std::min(passes, passes_);
  if (passes <= t.folded) return 0;
  std::uint32_t became = 0;
  if (passes > t.base) {
    const std::uint32_t by = passes - t.base;
    const std::uint32_t within = by < mask_bits ? (1U << by) - 1 : ~0U;
    became = by - static_cast<std::uint32_t>(std::popcount(t.closed & within));
    t.closed = shifted(t.closed, by);
    t.taken = shifted(t.taken, by);
    t.base = passes;
    advance_base(t);
  }
  t.folded = passes;
  if (passes == passes_) ++tiles_finished_;
  if (t.offered > 0) offer(index, t);
  return became;
}

bool FrameTasks::all_folded(std::uint32_t passes) {
  if (seen_passes_ != passes) seen_folded_ = 0;
  seen_passes_ = passes;
  while (seen_folded_ < tiles_ && folded(seen_folded_) >= passes) ++seen_folded_;
  return seen_folded_ == tiles_;
}

std::uint32_t FrameTasks::folded(std::uint32_t index) const { return tile(index).folded; }

void FrameTasks::advance_base(Tile& t) {
  const auto by = static_cast<std::uint32_t>(std::countr_one(t.closed));
  t.closed = shifted(t.closed, by);
  t.taken = shifted(t.taken, by);
  t.base += by;
}

void FrameTasks::offer(std::uint32_t index, Tile& t) {
  const std::uint32_t limit = std::min(offered_, t.folded + ahead_);
  for (; t.offered < limit; ++t.offered) {
    const FrameTask task{t.offered, index};
    if (state(task) == State::open) push(task);
  }
}

}  // namespace tessera::server
