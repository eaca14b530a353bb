#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "server/schedule/tile_order.hpp"

namespace tessera::server {

/// A tile and a pass of one frame.
struct FrameTask {
  std::uint32_t pass = 0;
  std::uint32_t tile = 0;
  auto operator<=>(const FrameTask&) const = default;
};

/// The tasks of one frame: which are open, taken (leased, set aside or being journaled), closed,
/// folded. Handed out by pass, and within a pass by rank; of a focus, after the first pass over the
/// whole frame, all passes go before those of other tiles. Twenty bytes a tile, allocated as the
/// frame's tiles are first touched; a call costs O(log tiles) at most, unless it says otherwise.
class FrameTasks {
 public:
  /// `ahead` ≤ 32: no pass is offered that is so far or more beyond its tile's fold.
  FrameTasks(std::shared_ptr<const TileRanks> ranks, std::uint32_t passes, std::uint32_t ahead);

  enum class State { open, taken, closed };
  [[nodiscard]] State state(const FrameTask& task) const;

  /// The first task that is open, offered and within the limit of passes ahead. May walk through
  /// tiles of which no pass is open; each of them once in each time that passes are offered.
  std::optional<FrameTask> peek();
  /// Passes [0, passes) are offered from now on, more than before; without a call all are.
  void offer_passes(std::uint32_t passes);
  [[nodiscard]] std::uint32_t offered() const { return offered_; }
  /// There are no more passes than these, fewer than before; later ones are neither taken nor
  /// closed. O(tiles).
  void cut(std::uint32_t passes);
  /// Which tiles come first, if any. O(tiles log tiles).
  void set_focus(const std::optional<FocusTiles>& focus);
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
  /// So many passes of every tile are folded. A call walks on from where the last one stood.
  [[nodiscard]] bool all_folded(std::uint32_t passes);
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

  /// A task's place in the queue: class, pass, rank.
  using Key = std::uint64_t;
  [[nodiscard]] Key key_of(const FrameTask& task) const;
  [[nodiscard]] FrameTask task_of(Key key) const;
  void push(const FrameTask& task);
  void pop();

  Tile& tile(std::uint32_t index);
  [[nodiscard]] const Tile& tile(std::uint32_t index) const;
  static void advance_base(Tile& tile);
  void offer(std::uint32_t index, Tile& tile);

  std::shared_ptr<const TileRanks> ranks_;
  std::uint32_t tiles_, passes_, ahead_;
  std::uint32_t offered_;     // passes [0, offered_) may be in the queue
  std::uint32_t sweep_from_;  // the passes that the sweep brings: from this one on
  std::optional<FocusTiles> focus_;
  std::vector<std::unique_ptr<Chunk>> chunks_;
  // A heap, the least first. Every open task that was offered stands here at least once; entries
  // that are open no more are dropped when they surface.
  std::vector<Key> queue_;
  std::uint32_t sweep_ = 0;  // tiles of ranks [0, sweep_) have been offered
  std::uint32_t tiles_finished_ = 0;
  // Tiles [0, seen_folded_) have seen_passes_ folded.
  std::uint32_t seen_folded_ = 0, seen_passes_ = 0;
};

}  // namespace tessera::server
