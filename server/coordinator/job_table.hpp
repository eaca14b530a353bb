#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/coordinator/coordinator.hpp"
#include "server/store/records.hpp"

/// The jobs and what is counted of them. Pure.
namespace tessera::server {

/// "done", "failed" or "cancelled": nothing changes any more.
bool is_end(const std::string& state);

/// Pictures of a job that has ended, which are to be tried again.
struct OwedPictures {
  Instant next{};   ///< when
  Duration wait{};  ///< before that
};

struct Job {
  Job(JobRecord from, Instant now, UnixMillis wall_now);

  JobRecord record;              ///< as the store has it, or is about to
  std::optional<JobRecord> end;  ///< what it ends with, as long as that is not durable
  std::shared_ptr<const JobPlan> plan;
  std::map<std::string, std::int64_t> shares;  ///< samples by worker's name
  std::set<std::int32_t> files;                ///< frames whose final EXR is written
  std::optional<Digest> build;                 ///< of the workers that made the results
  std::optional<Instant> first_lease, last_fold;
  std::uint64_t failures = 0;         ///< attempts at its tasks that gave no result
  std::string trouble;                ///< why its files cannot be written at present
  std::vector<Digest> earlier_plans;  ///< before it was extended
  std::uint64_t version_base = 0;     ///< no frame's version was larger under these
  double earlier_seconds = 0;         ///< render time under these
  std::set<std::int32_t> unsettled;  ///< finished frames whose film is not kept as a checkpoint yet
  std::set<std::int32_t> checkpointing;  ///< frames of which one is being made
  int arriving = 0;                      ///< results on their way to the journal
  int at_work = 0;                       ///< coroutines that end or keep something of it
  /// It has failed or is cancelled, and its pictures so far may not be written: what it had stays.
  std::optional<OwedPictures> owed;
  bool unwanted = false;  ///< somebody waits to remove it: nothing more of it is to be kept
  bool extending = false;
  bool removing = false;   ///< it is being forgotten
  bool changing = false;   ///< a change that somebody asked for is being kept
  bool unsaved = false;    ///< the record differs from what was last given to the store
  bool keeping = false;    ///< …, and somebody sees to it
  bool shortened = false;  ///< its samples are fewer than were asked for, which is not durable yet
  std::set<std::int32_t> shortened_unsaved;  ///< frames of whose end the store says something else
  bool ending = false;     ///< the scheduler is done with it; files and state are being written
  bool ended = false;      ///< the end is durable
  bool broken = false;     ///< what was durable cannot be read back: it has failed in this run
  std::string unreadable;  ///< then: why

  /// It has ended, and nothing goes on with it.
  [[nodiscard]] bool at_rest() const {
    return ended && at_work == 0 && arriving == 0 && !extending && !removing;
  }
  /// The end is durable. Frames that were shortened meanwhile are so still.
  void has_ended_as(const JobRecord& kept);
  /// What the store is to have now.
  [[nodiscard]] const JobRecord& to_keep() const { return end ? *end : record; }
  /// The record's spec or priority has another value: the plan says the same.
  void spec_changed();
  /// A result has become durable, or is read back after a start.
  void count(const std::string& worker, std::int64_t samples, std::int64_t rays,
             std::int64_t rejected, double cpu_seconds, const Digest& worker_build);
  /// From the first lease to now while anything is `leased`, else to the last fold. A time for
  /// which the coordinator was down in between counts.
  [[nodiscard]] double render_seconds(Instant now, bool leased) const;
  [[nodiscard]] std::int64_t samples_total() const;
  /// Tasks of all frames, of each the passes that it has or is to have at most.
  [[nodiscard]] std::int64_t tasks_total() const;
  /// True as long as somebody waits for what a look at a frame's noise says that was asked for
  /// under this plan.
  [[nodiscard]] bool awaits_noise(const Digest& of_plan) const;
  /// Samples of each pixel that the frame has, or is to have at most; and the passes of these.
  [[nodiscard]] std::int64_t samples_of(std::int32_t frame) const;
  [[nodiscard]] std::uint32_t passes_of(std::int32_t frame) const;
  /// Most first; equal ones by name.
  [[nodiscard]] std::vector<JobRecord::Share> shares_by_size() const;
  /// The record as it is to be kept when the job ends in this state.
  [[nodiscard]] JobRecord end_record(const std::string& state, const std::string& error,
                                     Instant now, UnixMillis wall_now) const;
  /// What people are shown. `view` is the scheduler's, if it still knows the job. A job is "done"
  /// only once its files are written.
  [[nodiscard]] JobStatus status(const std::optional<JobView>& view, Instant now) const;
};

/// Fewest and most samples of each pixel that a frame of the job has, or is to have at most.
struct SamplesOfFrames {
  std::int64_t fewest = 0, most = 0;
};
SamplesOfFrames samples_of_frames(const Job& job);

/// A frame's version once its file stands: at least any that was told before.
std::uint64_t final_version(const Job& job);

// ---- the data of events: JSON objects ----
std::string job_event(const JobStatus& status);
std::string removed_event(const Job& job);
std::string frame_event(JobId job, std::int32_t frame, std::uint64_t version);
std::string worker_event(WorkerId worker, const std::string& name, const char* state);

}  // namespace tessera::server
