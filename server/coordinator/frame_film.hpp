#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/image/tile_view.hpp"
#include "common/job/job_spec.hpp"
#include "server/film/film.hpp"
#include "server/store/records.hpp"

/// One frame's film, and what of it is durable but not folded yet: decides what is folded when.
/// Pure.
namespace tessera::server {

/// A tile that was checked: where its pixels stand in the bytes of its EXR, which it keeps, and its
/// share of the budget of results in flight, which ends with it.
struct DecodedTile {
  std::shared_ptr<const std::vector<std::byte>> exr;
  image::TileView pixels;
  std::shared_ptr<void> budget;
};
/// Throws Error{bad_input}.
DecodedTile decode(std::shared_ptr<const std::vector<std::byte>> exr,
                   const image::TileExpectation& expected);

/// Passes of one tile to be folded on a thread of the pool, in this order.
struct FoldWork {
  struct Pass {
    std::uint32_t pass = 0;
    ResultPlace place;  ///< where it is read back from, if it is not here:
    std::shared_ptr<const DecodedTile> tile;
  };
  std::uint32_t tile = 0;
  bool loads = false;  ///< only brings back what was folded before, and is not in memory
  std::optional<CheckpointPlace> checkpoint;  ///< what is read first, then
  std::shared_ptr<FilmTile> own;              ///< the film's own sums, to be folded into
  std::shared_ptr<const FilmTile> before;     ///< else what to copy first; nullptr: nothing yet
  std::vector<Pass> passes;
};

/// A pass that has its predecessors folded (or about to be) keeps its decoded tile; one that is
/// early keeps its place in the journal alone. Tiles that are not in memory, after a start or
/// drop(), are read back when they are needed: by a new pass, or by demand().
///
/// The version: a restart begins at the number of passes that are durable in order, over all tiles.
/// No version told earlier is larger, and an equal one means equal pictures.
class FrameFilm {
 public:
  /// `version`: at least what was told of the frame under earlier plans of its job.
  FrameFilm(std::shared_ptr<const JobPlan> plan, std::int32_t frame, std::uint64_t version = 0);

  // ---- after a start, before anything else ----
  /// Passes [0, passes) are in the frame's checkpoint.
  void restore_checkpoint(std::uint32_t tile, std::uint32_t passes, const CheckpointPlace& place);
  void restore(std::uint32_t tile, std::uint32_t pass, const ResultPlace& place);
  /// Ends restoring. What is durable in order counts as folded from here on.
  void restored();
  /// Passes of the tile that count as folded.
  [[nodiscard]] std::uint32_t passes(std::uint32_t tile) const { return tiles_[tile].folded; }

  // ---- folding ----
  /// The result is in the journal. A second one for the same pass changes nothing.
  void durable(std::uint32_t tile, std::uint32_t pass, const ResultPlace& place,
               std::shared_ptr<const DecodedTile> decoded);
  /// What is to be folded next into this tile; nothing while it is being folded. done() must
  /// follow.
  std::optional<FoldWork> next(std::uint32_t tile);
  /// A snapshot is wanted: next() of every tile tells what was folded before a restart and is to be
  /// read, and lends no more of the film's own tiles, until the snapshot is taken.
  void demand();
  /// The work is done; nobody else holds `folded`. True if passes(tile) has grown.
  bool done(const FoldWork& work, std::shared_ptr<FilmTile> folded);

  // ---- keeping ----
  /// From here on the tiles of the checkpoint are read back from it, and what follows from the
  /// journal. It holds no more of any tile than counts as folded.
  void checkpointed(const Checkpoint& checkpoint);
  /// Bytes of the journal that a checkpoint of what is folded now would take the place of. 0 if
  /// there can be none: a tile holds a pass that a longer plan would not have.
  [[nodiscard]] std::uint64_t journal_bytes() const { return irregular_ > 0 ? 0 : journal_bytes_; }
  /// Bytes of its sums that are in memory.
  [[nodiscard]] std::size_t memory() const { return memory_; }
  /// Lets go of the tiles that are not being folded into. Not while a snapshot is wanted.
  void drop();
  [[nodiscard]] bool demanded() const { return demanded_; }

  // ---- looking ----
  /// True if everything that counts as folded is here, and nothing of it is being folded into.
  [[nodiscard]] bool loaded() const { return unloaded_ == 0 && lent_ == 0; }
  [[nodiscard]] std::uint64_t version() const { return film_.version(); }
  /// Pixels × samples of all that counts as folded.
  [[nodiscard]] std::int64_t samples() const;
  /// Needs loaded().
  [[nodiscard]] FilmSnapshot snapshot();
  [[nodiscard]] std::uint32_t tile_count() const {
    return static_cast<std::uint32_t>(tiles_.size());
  }
  [[nodiscard]] const JobPlan& plan() const { return *plan_; }
  [[nodiscard]] std::int32_t frame() const { return frame_; }
  [[nodiscard]] const image::Layout& layout() const { return layout_; }

 private:
  struct Tile {
    std::uint32_t folded = 0;  ///< passes that count as folded
    bool unloaded = false;     ///< … but are on disk alone
    bool busy = false;
    std::uint32_t kept = 0;               ///< passes that are in the checkpoint
    CheckpointPlace checkpoint;           ///< if there are any
    std::vector<ResultPlace> places;      ///< of passes [kept, folded) in the journal
    std::uint32_t busy_end = 0;           ///< while busy: where the fold under way ends
    std::vector<FoldWork::Pass> waiting;  ///< ascending by pass
  };

  [[nodiscard]] static std::size_t run_length(const Tile& tile, std::uint32_t first);
  [[nodiscard]] std::size_t bytes_of(std::uint32_t tile) const;

  std::shared_ptr<const JobPlan> plan_;
  std::int32_t frame_;
  image::Layout layout_;
  Film film_;
  std::vector<Tile> tiles_;
  std::size_t unloaded_ = 0;
  std::size_t lent_ = 0;  ///< tiles whose sums are being folded into
  std::size_t memory_ = 0;
  std::size_t irregular_ = 0;        ///< tiles that hold a pass beyond the plan's regular ones
  std::uint64_t journal_bytes_ = 0;  ///< of all `places`
  bool demanded_ = false;
};

/// What a task's result must be.
image::TileExpectation expectation_of(const JobPlan& plan, const TaskId& task);

}  // namespace tessera::server
