#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

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

/// What the coordinator's disk holds: it outlives the coordinator.
struct Disk {
  struct Job {
    std::shared_ptr<const JobPlan> plan;
    std::map<TaskId, std::shared_ptr<const image::TileImage>> results;
    std::string ended;  // "done", "cancelled", "failed", or not yet
    /// As written to the finished picture, by frame and tile.
    std::map<std::pair<std::int32_t, std::uint32_t>, server::FilmTile> finished;
  };
  std::uint64_t epoch = 0;
  std::map<JobId, Job> jobs;

  /// A result becomes durable.
  void keep(JobId job, const TaskId& task, std::shared_ptr<const image::TileImage> tile);
};

/// What was said to workers, kept outside the coordinator.
using Acknowledged = std::set<std::pair<JobId, TaskId>>;

/// After a run: every task of every job that is done was counted exactly once, its film has the
/// straight fold's bits, and nothing that was acknowledged is lost. Throws Violation.
void audit(const Disk& disk, const Acknowledged& acknowledged);

}  // namespace tessera::sim
