#pragma once
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/coordinator/crew.hpp"
#include "server/coordinator/frame_film.hpp"

/// The films of all frames under way; folds on the pool. Used on the I/O thread alone.
namespace tessera::server {

class Films {
 public:
  /// Where tiles are read back from; any thread. Both throw Error.
  struct Source {
    /// A result's, from the journal, decoded.
    std::function<DecodedTile(const ResultPlace&, const image::TileExpectation&)> result;
    /// A film's, from its checkpoint.
    std::function<FilmTile(const CheckpointPlace&, const Rect&, const image::Layout&)> checkpoint;
  };
  struct Hooks {
    /// Passes [0, passes) of the tile are folded; the frame has a new version.
    std::function<void(JobId, std::int32_t frame, std::uint32_t tile, std::uint32_t passes)> folded;
    /// A result that was durable could not be read back, however often it was tried.
    std::function<void(JobId, const std::string& reason)> failed;
    /// A batch of folds has ended.
    std::function<void()> settled;
  };

  /// `crew` counts the work that is on the pool. `lanes`: threads of the pool. `memory_most`: bytes
  /// of films in memory beyond which those used longest ago are dropped, but for those that are
  /// held or wanted and for tiles that are being folded: these are a quarter as much at most, or
  /// one.
  Films(boost::asio::any_io_executor io, boost::asio::thread_pool& pool, int lanes, Crew& crew,
        std::uint64_t memory_most, Source source, Hooks hooks);

  /// The frame's film, an empty one at `version` if there is none yet.
  FrameFilm& open(JobId job, const std::shared_ptr<const JobPlan>& plan, std::int32_t frame,
                  std::uint64_t version);
  /// nullptr if there is none.
  [[nodiscard]] const FrameFilm* find(JobId job, std::int32_t frame) const;
  [[nodiscard]] std::vector<std::int32_t> frames(JobId job) const;

  /// The result is in the journal; it is folded when its turn comes. Call flush() after the last of
  /// a batch.
  void durable(JobId job, const std::shared_ptr<const JobPlan>& plan, std::uint64_t version,
               const TaskId& task, const ResultPlace& place,
               std::shared_ptr<const DecodedTile> decoded);
  /// Hands what has its turn to the pool, as much at once as folding has memory for; the rest
  /// follows as that ends.
  void flush();

  /// The film as far as it counts as folded; reads back what is in the journal alone. Throws
  /// Error{not_found} if there is no film, or it is forgotten meanwhile; Error{failed} if it cannot
  /// be read back.
  boost::asio::awaitable<FilmSnapshot> snapshot(JobId job, std::int32_t frame);

  /// The frame's checkpoint is in the store. Between the snapshot that it was made of and this call
  /// nothing of the frame may be read back: hold it.
  void checkpointed(const Checkpoint& checkpoint);
  /// While held, the frame is not dropped from memory.
  void hold(JobId job, std::int32_t frame, bool held);

  void forget(JobId job, std::int32_t frame);
  void forget(JobId job);

  /// Bytes of films in memory.
  [[nodiscard]] std::uint64_t memory() const { return memory_; }

 private:
  struct Frame {
    Frame(JobId of, const std::shared_ptr<const JobPlan>& plan, std::int32_t number,
          std::uint64_t version, const boost::asio::any_io_executor& io)
        : job(of), film(plan, number, version), changed(io) {}
    JobId job;
    FrameFilm film;
    Signal changed;
    std::string error;
    int holds = 0;
    std::uint64_t used = 0;
    bool gone = false;
  };
  using FramePtr = std::shared_ptr<Frame>;
  struct Fold {
    FramePtr frame;
    FoldWork work;
    std::uint64_t bytes = 0;  ///< of the tile's sums
    std::shared_ptr<FilmTile> folded;
    std::string error;
    std::size_t tries = 0;  ///< that have failed, each followed by another
  };
  using Batch = std::shared_ptr<std::vector<Fold>>;

  void touch(const FramePtr& frame, std::uint32_t tile);
  void post(Batch batch);
  void fold(Fold& fold) const;
  /// After a pause, for what is out of descriptors or memory now may have them then.
  boost::asio::awaitable<void> fold_again(Batch batch);
  [[nodiscard]] std::shared_ptr<FilmTile> begin(const FrameFilm& film, const FoldWork& work) const;
  void finish(const Batch& batch);
  void trim();

  boost::asio::any_io_executor io_;
  boost::asio::thread_pool& pool_;
  std::size_t lanes_;
  Crew& crew_;
  std::uint64_t memory_most_;
  std::uint64_t memory_ = 0;
  std::uint64_t folding_ = 0;  ///< bytes of the tiles that flush() gave to the pool
  std::uint64_t clock_ = 0;
  Source source_;
  Hooks hooks_;
  std::map<std::pair<JobId, std::int32_t>, FramePtr> frames_;
  std::deque<std::pair<FramePtr, std::uint32_t>> touched_;
};

}  // namespace tessera::server
