#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <queue>
#include <vector>

namespace tessera::server {

/// A tile and a pass of one frame; sorts in the order in which tasks are handed out: the first pass
/// over the whole frame first.
struct FrameTask {
  std::uint32_t pass = 0;
  std::uint32_t tile = 0;
  auto operator<=>(const FrameTask&) const = default;
};

/// The tasks of one frame: which are open, taken (leased, set aside or being journaled), closed,
/// folded. Twenty bytes a tile, allocated as the frame's tiles are first touched; a call costs
/// O(log tiles) at most.
class FrameTasks {
 public:
  /// `ahead` ≤ 32: no pass is offered that is so far or more beyond its tile's fold.
  FrameTasks(std::uint32_t tiles, std::uint32_t passes, std::uint32_t ahead);

  enum class State { open, taken, closed };
  [[nodiscard]] State state(const FrameTask& task) const;

  /// The first task that is open and within the limit of passes ahead.
  std::optional<FrameTask> peek();
  /// open → taken; false if it is not open, or so far ahead of what is closed that it cannot have
  /// been offered.
  bool take(const FrameTask& task);
  /// taken → open.
  void reopen(const FrameTask& task);
  /// → closed; false if it was closed before, or (out of a start's order) is too far ahead to be
  /// remembered.
  bool close(const FrameTask& task);
  /// Passes [0, passes) are folded; what was not yet closed of them becomes so. Returns how many
  /// became closed by it.
  std::uint32_t fold(std::uint32_t tile, std::uint32_t passes);
  [[nodiscard]] std::uint32_t folded(std::uint32_t tile) const;
  /// Within the limit of passes ahead.
  [[nodiscard]] bool within(const FrameTask& task) const {
    return task.pass < folded(task.tile) + ahead_;
  }
  /// Every pass of every tile is folded.
  [[nodiscard]] bool finished() const { return tiles_finished_ == tiles_; }

 private:
  struct Tile {
    std::uint32_t folded = 0;  // passes [0, folded)
    std::uint32_t base = 0;    // passes [0, base) are closed
    std::uint32_t closed = 0;  // bit i: pass base + i is closed
    std::uint32_t taken = 0;   // bit i: pass base + i is taken
    std::uint32_t offered =
        0;  // passes [0, offered) have been in the queue; 0: the sweep has not come by
  };
  static constexpr std::uint32_t chunk_tiles = 1024;
  using Chunk = std::array<Tile, chunk_tiles>;

  Tile& tile(std::uint32_t index);
  [[nodiscard]] const Tile& tile(std::uint32_t index) const;
  static void advance_base(Tile& tile);
  void offer(std::uint32_t index, Tile& tile);

  std::uint32_t tiles_, passes_, ahead_;
  std::vector<std::unique_ptr<Chunk>> chunks_;
  // Every open task that was offered stands here at least once; entries that are open no more are
  // dropped when they surface.
  std::priority_queue<FrameTask, std::vector<FrameTask>, std::greater<>> queue_;
  std::uint32_t sweep_ = 0;  // tiles [0, sweep_) have been offered
  std::uint32_t tiles_finished_ = 0;
};

}  // namespace tessera::server
