#pragma once
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/clock.hpp"
#include "common/job/task.hpp"

/// Spaces out the news that a job's pictures have changed. Pure.
namespace tessera::server {

class FrameThrottle {
 public:
  /// At least `spacing` lies between two pieces of news of one job.
  explicit FrameThrottle(Duration spacing) : spacing_(spacing) {}

  using Frame = std::pair<JobId, std::int32_t>;

  /// The frame has a new version; it is told of by due(), at once if nothing of its job was told
  /// lately.
  void changed(JobId job, std::int32_t frame, Instant now);
  /// What is to be told now, at most one frame of each job: the one that has waited longest.
  std::vector<Frame> due(Instant now);
  [[nodiscard]] std::optional<Instant> next_deadline() const;
  /// What waits of this job, told regardless of the spacing; the job is known no more.
  std::vector<Frame> forget(JobId job);

 private:
  struct Job {
    Instant free;                      ///< nothing is told before
    std::deque<std::int32_t> waiting;  ///< each frame once, longest first
  };
  Duration spacing_;
  std::map<JobId, Job> jobs_;
};

}  // namespace tessera::server
