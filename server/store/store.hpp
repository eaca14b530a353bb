#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/base/limits.hpp"
#include "server/store/checkpoint_files.hpp"
#include "server/store/disk.hpp"
#include "server/store/records.hpp"

/// What a coordinator keeps on disk: jobs and results, in one data folder that it locks.
namespace tessera::server {

struct StoreSettings {
  /// false: nothing is synced, and a power cut may lose what was acknowledged (a killed process
  /// still loses nothing).
  bool durable = true;
  /// A segment that has reached this is closed and a new one begun, bytes.
  std::uint64_t segment_bytes = 256 * limits::MiB;
  std::shared_ptr<Disk> disk = system_disk();
};

/// Two kinds of calls. Those that are not const change the store: they block on the disk and are
/// made by one thread at a time (the writer's). Const calls may be made by any thread at any time,
/// also while the writer writes; they block on reading alone. Every call throws Error{failed} with
/// the file's name when the disk or the database fails; the store then holds what it held before
/// the call, and can be called again.
class Store {
 public:
  /// Locks the folder (made if it is not there), brings the database to this schema, deletes what
  /// no job needs, and counts a new epoch, durably. Throws Error{conflict} if another coordinator
  /// holds the folder or it was written by a newer schema, Error{failed} if it cannot be written or
  /// the database is damaged. A segment or checkpoint that is lacking, or cannot be looked at,
  /// costs the jobs that need it alone: damage().
  static std::unique_ptr<Store> open(const std::filesystem::path& folder,
                                     const StoreSettings& settings = {});
  ~Store();
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  [[nodiscard]] const std::filesystem::path& folder() const;
  /// Counts the opens of this folder, from 1.
  [[nodiscard]] std::uint64_t epoch() const;
  /// Jobs of which something that is indexed was not there at the open, or could not be looked at:
  /// which file, and what of the job is in it. All else of them, and all other jobs, can be read.
  [[nodiscard]] const std::map<JobId, std::string>& damage() const;
  /// The secret of this folder, made once: SchedulerSettings::grant_key.
  [[nodiscard]] const std::array<std::uint8_t, 16>& grant_key() const;

  // ---- jobs: durable on return ----
  /// Keeps a new job and gives it its id; `record.id` is ignored.
  JobId put_job(const JobRecord& record);
  /// Jobs are numbered from above `last` on.
  void skip_jobs(JobId last);
  /// Replaces all but id and shortened frames. Throws Error{not_found}.
  void update_job(const JobRecord& record);
  /// The frame ended with so many samples of each pixel. Takes the place of what was said of it
  /// before. Throws Error{not_found}.
  void shorten_frame(JobId job, std::int32_t frame, std::int64_t samples);
  /// The frame has not ended early: nothing is said of it any more, if anything was.
  void unshorten_frame(JobId job, std::int32_t frame);
  /// Replaces all but id, at once with this: results from pass `passes` on are not the job's any
  /// more, and no frame is shortened. Throws Error{not_found}.
  void extend_job(const JobRecord& record, std::uint32_t passes);
  /// Nothing of the job is left. Its number is not given again.
  void forget_job(JobId job);
  /// All jobs by id.
  [[nodiscard]] std::vector<JobRecord> list_jobs() const;

  // ---- failures: for people; durable on return ----
  /// The newest so many of each job are kept.
  static constexpr std::size_t failures_kept = 100;
  /// Numbers them on from those that the job had.
  void add_failures(JobId job, std::span<const FailureRecord> failures);
  /// Those that are kept, newest first.
  [[nodiscard]] std::vector<FailureRecord> failures(JobId job) const;
  /// How many each job had in all, where it had any.
  [[nodiscard]] std::map<JobId, std::uint64_t> failure_counts() const;

  // ---- quarantines: durable on return ----
  /// Takes the place of an earlier one of that name.
  void put_quarantine(const Quarantine& quarantine);
  /// Nothing happens if there is none.
  void remove_quarantine(const std::string& name);
  /// By name.
  [[nodiscard]] std::vector<Quarantine> quarantines() const;

  // ---- results ----
  /// Journal, one sync, index, one commit: on return every result of the batch is durable and may
  /// be acknowledged. If it throws, none of them is. A second result for the same task replaces the
  /// first in the index; jobs must be known.
  std::vector<ResultPlace> append_results(std::span<const NewResult> batch);
  /// Calls `visit` for every result of the job (of one frame), in the order of frame, tile, pass.
  /// `visit` must not call the store.
  void results_of(JobId job, const std::function<void(const IndexedResult&)>& visit) const;
  void results_of(JobId job, std::int32_t frame,
                  const std::function<void(const IndexedResult&)>& visit) const;
  /// Reads one record and checks it against its CRC. Throws DamagedError if the record is damaged,
  /// Error{failed} if it cannot be read.
  [[nodiscard]] StoredResult read_result(const ResultPlace& place) const;
  /// Jobs that have results, or had some since their last end_job.
  [[nodiscard]] std::vector<JobId> jobs_with_results() const;
  /// The job's results are needed no more: they leave the index, and segments that hold nothing
  /// else are deleted. Checkpoints and the job's record stay.
  void forget_results(JobId job);
  /// … and checkpoints neither.
  void end_job(JobId job);

  // ---- checkpoints ----
  /// A file that nothing knows of until put_checkpoint; any thread.
  [[nodiscard]] std::unique_ptr<CheckpointWriter> begin_checkpoint(JobId job,
                                                                   std::int32_t frame) const;
  /// Durable on return: the checkpoint takes the place of the frame's earlier one, whose file is
  /// deleted, and of the results that it holds, which are counted by worker in the job's tallies
  /// and leave the index. Nobody may be reading either of them. Throws Error{failed} if it holds
  /// less of a tile than the earlier one.
  void put_checkpoint(const Checkpoint& checkpoint);
  /// Where it throws, the checkpoint can be put again, or is discarded: it will not be put any
  /// more, and its file goes with the next commit, unless it counts after all. Does not throw.
  void discard_checkpoint(const Checkpoint& checkpoint);
  [[nodiscard]] std::optional<Checkpoint> checkpoint_of(JobId job, std::int32_t frame) const;
  [[nodiscard]] std::vector<JobId> jobs_with_checkpoints() const;
  /// By frame.
  [[nodiscard]] std::vector<Checkpoint> checkpoints_of(JobId job) const;
  /// One tile's content, checked against its CRC. Throws as read_result does.
  [[nodiscard]] std::vector<std::byte> read_checkpoint(const CheckpointPlace& place) const;
  [[nodiscard]] std::vector<Tally> tallies_of(JobId job) const;

  /// Bytes of the journal on disk, and of all checkpoints.
  [[nodiscard]] std::uint64_t journal_bytes() const;
  [[nodiscard]] std::uint64_t checkpoint_bytes() const;

 private:
  struct State;
  explicit Store(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tessera::server
