#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "server/store/store.hpp"
#include "tests/sim/disk/sim_disk.hpp"
#include "tests/sim/ledger.hpp"

namespace tessera::sim {

/// What the store was told to keep: what it said was kept, and the changes that it was told since
/// without an answer. Each change is one commit: at a start all of it is there, or nothing.
template <class Value>
class Kept {
 public:
  using Change = std::function<void(Value&)>;
  void acknowledge(const Change& change) {
    change(value_);
    doubtful_.clear();
  }
  void doubt(Change change) { doubtful_.push_back(std::move(change)); }
  void tell(const Change& change, bool done) { done ? acknowledge(change) : doubt(change); }
  [[nodiscard]] const Value& value() const { return value_; }
  [[nodiscard]] bool may_be(const Value& found) const {
    if (found == value_) return true;
    for (const Change& change : doubtful_) {
      Value changed = value_;
      change(changed);
      if (found == changed) return true;
    }
    return false;
  }
  /// A start has shown what there is.
  void found(Value value) {
    value_ = std::move(value);
    doubtful_.clear();
  }

 private:
  Value value_{};
  std::vector<Change> doubtful_;
};

/// All that the store holds of one job.
struct JobTruth {
  /// What a checkpoint holds of a tile: so many passes, and a hash over the attempts behind them.
  struct Tile {
    std::uint32_t passes = 0;
    std::uint64_t folded = 0;
    bool operator==(const Tile&) const = default;
  };
  using Film = std::map<std::uint32_t, Tile>;

  std::string state;                               // empty: there is no such job
  std::map<std::int32_t, std::int64_t> shortened;  // frames that ended early: their samples
  std::map<TaskId, std::uint64_t> results;         // by the attempt's number
  std::map<std::int32_t, Film> checkpoints;        // by frame
  std::map<std::string, std::int64_t> tallies;     // samples of what checkpoints hold, by worker
  std::vector<std::string> failures;               // newest first
  bool operator==(const JobTruth&) const = default;

  /// Passes of the tile that are in the frame's checkpoint.
  [[nodiscard]] std::uint32_t kept(std::int32_t frame, std::uint32_t tile) const;
  /// The frame's checkpoint, and the results that follow it without a gap, at most so many of each
  /// tile.
  [[nodiscard]] Film folded(std::int32_t frame, std::uint32_t tiles, std::uint32_t most) const;
  /// The film takes the place of the results that it holds.
  void compact(std::int32_t frame, const Film& film);
};

/// The log of acknowledgements, kept outside of the store, and what the store is held to by it.
class Books {
 public:
  std::map<JobId, Kept<JobTruth>> jobs;
  std::set<std::string> doubtful_new;  // names of jobs that were put without an answer
  std::map<std::int32_t, Kept<std::uint64_t>> frames;  // files of finished pictures
  JobId numbered = 0;                                  // jobs have numbers above this
  std::uint64_t epoch = 0;
  std::optional<std::array<std::uint8_t, 16>> key;

  /// Within one life the store holds what it said; after a start it may also hold what was under
  /// way, and from then on does. Throws Violation.
  void check(const server::Store& store, SimDisk& disk, bool started);

 private:
  void check_jobs(const server::Store& store, bool started);
  void check_frames(SimDisk& disk, bool started);
};

/// Nothing is on the disk that the store does not know: after an open at which nothing failed.
void check_no_surplus(const server::Store& store, SimDisk& disk);

/// The bytes of attempt `number` at the task.
std::vector<std::byte> bytes_of(const TaskId& task, std::uint64_t number);
server::ResultInfo info_of(JobId job, const TaskId& task, std::uint64_t number);
std::string worker_name_of(std::uint64_t number);
/// What a checkpoint says of a tile.
std::vector<std::byte> bytes_of(std::int32_t frame, std::uint32_t tile, const JobTruth::Tile& held);
std::filesystem::path frame_file(std::int32_t frame);

}  // namespace tessera::sim
