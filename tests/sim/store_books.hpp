#pragma once
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/store/store.hpp"
#include "tests/sim/disk/sim_disk.hpp"
#include "tests/sim/ledger.hpp"

namespace tessera::sim {

/// One thing that the store was told to keep: what it said was kept, and what it was told since
/// without an answer.
template <class Value>
class Kept {
 public:
  void acknowledge(Value value) {
    value_ = std::move(value);
    doubtful_.clear();
  }
  void doubt(Value value) { doubtful_.push_back(std::move(value)); }
  [[nodiscard]] const Value& value() const { return value_; }
  [[nodiscard]] bool may_be(const Value& found) const {
    if (found == value_) return true;
    for (const Value& one : doubtful_)
      if (found == one) return true;
    return false;
  }

 private:
  Value value_{};
  std::vector<Value> doubtful_;
};

/// The log of acknowledgements, kept outside of the store, and what the store is held to by it.
class Books {
 public:
  struct JobTruth {
    Kept<std::string> state;                        // empty: there is no such job
    std::map<TaskId, Kept<std::uint64_t>> results;  // by the attempt's number; 0: none
  };
  std::map<JobId, JobTruth> jobs;
  std::set<std::string> doubtful_new;  // names of jobs that were put without an answer
  std::map<std::int32_t, Kept<std::uint64_t>> frames;  // files of finished pictures
  std::uint64_t epoch = 0;
  std::optional<std::array<std::uint8_t, 16>> key;

  /// Within one life the store holds what it said; after a start it may also hold what was under
  /// way, and from then on does. Throws Violation.
  void check(const server::Store& store, SimDisk& disk, bool started);

 private:
  void check_jobs(const server::Store& store, bool started);
  void check_results(const server::Store& store, JobId job, JobTruth& truth, bool started);
  void check_frames(SimDisk& disk, bool started);
};

/// The bytes of attempt `number` at the task.
std::vector<std::byte> bytes_of(const TaskId& task, std::uint64_t number);
server::ResultInfo info_of(JobId job, const TaskId& task, std::uint64_t number);
std::filesystem::path frame_file(std::int32_t frame);

}  // namespace tessera::sim
