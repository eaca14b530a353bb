#include "server/schedule/frame_tasks.hpp"

#include <algorithm>
#include <bit>
#include <cassert>

namespace tessera::server {
namespace {

constexpr std::uint32_t mask_bits = 32;
// So many tiles at most are swept in one call while the queue has something else to give.
constexpr std::uint32_t sweep_most = 1024;

std::uint32_t shifted(std::uint32_t mask, std::uint32_t by) {
  return by < mask_bits ? mask >> by : 0;
}

}  // namespace

FrameTasks::FrameTasks(std::uint32_t tiles, std::uint32_t passes, std::uint32_t ahead)
    : tiles_(tiles),
      passes_(passes),
      ahead_(ahead),
      chunks_((tiles + chunk_tiles - 1) / chunk_tiles) {
  assert(ahead >= 1 && ahead <= mask_bits);
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
    while (!queue_.empty() && state(queue_.top()) != State::open) queue_.pop();
    if (!queue_.empty() && (queue_.top().pass == 0 || sweep_ == tiles_ || swept >= sweep_most))
      return queue_.top();
    if (sweep_ == tiles_) return std::nullopt;
    Tile& t = tile(sweep_);
    offer(sweep_++, t);
    ++swept;
  }
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
  if (task.pass < t.offered) queue_.push(task);
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

std::uint32_t FrameTasks::folded(std::uint32_t index) const { return tile(index).folded; }

void FrameTasks::advance_base(Tile& t) {
  const auto by = static_cast<std::uint32_t>(std::countr_one(t.closed));
  t.closed = shifted(t.closed, by);
  t.taken = shifted(t.taken, by);
  t.base += by;
}

void FrameTasks::offer(std::uint32_t index, Tile& t) {
  const std::uint32_t limit = std::min(passes_, t.folded + ahead_);
  for (; t.offered < limit; ++t.offered) {
    const FrameTask task{t.offered, index};
    if (state(task) == State::open) queue_.push(task);
  }
}

}  // namespace tessera::server
