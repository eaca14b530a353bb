#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/image/tile.hpp"
#include "common/job/job_spec.hpp"
#include "server/film/film_tile.hpp"

namespace tessera::sim {

/// A rule that was broken; what() says which, and where.
class Violation : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

void require(bool holds, const std::string& rule);
/// The same where the rule's words cost more than to look whether it holds.
template <class Words, class = decltype(std::declval<Words>()())>
void require(bool holds, const Words& words) {
  if (!holds) throw Violation(words());
}

using Bytes = std::shared_ptr<const std::vector<std::byte>>;

/// What the coordinator's disk is known to hold: kept outside the coordinator, and held against
/// what its store says after each start.
struct Disk {
  struct Job {
    std::shared_ptr<const JobPlan> plan;
    std::shared_ptr<const JobPlan> asked;  // before its time was up, or its noise low enough
    std::map<std::int32_t, std::int64_t>
        shortened;  // of several frames: kept that they end with so many
    std::map<std::int32_t, std::int64_t> said;  // … or that was to be kept
    std::set<std::int64_t> doubtful_samples;    // that its time is up was to be kept: with so many
    std::map<TaskId, Bytes> results;            // in the journal, or in a checkpoint
    std::string ended;                          // "done", "cancelled", "failed", or not yet
    std::set<std::string> doubtful_ends;        // asked for, and not answered
    std::set<std::int32_t> files;               // frames whose picture is written
  };
  std::map<JobId, Job> jobs;
  /// Passes of the frame, if noise ends it: found once, by plain loops.
  std::uint32_t passes_alone(JobId job, std::int32_t frame);
  std::map<std::pair<JobId, std::int32_t>, std::uint32_t> alone;

  /// A result is durable.
  void keep(JobId job, const TaskId& task, Bytes bytes);
};

/// On the simulated disk.
inline const std::filesystem::path data_folder = "/farm/data";

/// What was said to workers, kept outside the coordinator.
using Acknowledged = std::set<std::pair<JobId, TaskId>>;

/// The picture of a frame as it was read back: one film tile for each of the grid's.
using ReadPicture = std::function<std::vector<server::FilmTile>(JobId, std::int32_t frame)>;

/// After a run: every task of every job that is done was counted exactly once, its pictures have
/// the straight fold's bits, frames that noise ends have as many passes as alone, and nothing that
/// was acknowledged is lost. Throws Violation.
void audit(Disk& disk, const Acknowledged& acknowledged, const ReadPicture& read);

}  // namespace tessera::sim
