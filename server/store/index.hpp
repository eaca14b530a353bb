#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "server/store/database.hpp"
#include "server/store/records.hpp"

namespace tessera::server {

/// A file that rows of a job name, and how long it must be for them.
struct IndexedFile {
  std::uint64_t number = 0;
  JobId job = 0;
  std::uint64_t bytes = 0;
};

/// The database side of the store: meta, jobs, workers, and the journal's index. Not const: one
/// thread at a time, over one connection; const: any thread, over another one, one after another.
class Index {
 public:
  /// `vfs` as Disk::sqlite_vfs() says.
  Index(const std::filesystem::path& file, bool durable, const char* vfs = nullptr);

  /// Counts a start; durable on return.
  std::uint64_t next_epoch();
  /// 32 hexadecimal digits, the same for good.
  std::string grant_key();

  JobId put_job(const JobRecord& record);
  void skip_jobs(JobId last);
  void update_job(const JobRecord& record);
  void shorten_frame(JobId job, std::int32_t frame, std::int64_t samples);
  void unshorten_frame(JobId job, std::int32_t frame);
  [[nodiscard]] std::vector<JobRecord> list_jobs() const;

  void add_failures(JobId job, std::span<const FailureRecord> failures, std::size_t kept);
  [[nodiscard]] std::vector<FailureRecord> failures(JobId job) const;
  [[nodiscard]] std::map<JobId, std::uint64_t> failure_counts() const;

  // ---- quarantines.cpp ----
  void put_quarantine(const Quarantine& quarantine);
  void remove_quarantine(const std::string& name);
  [[nodiscard]] std::vector<Quarantine> quarantines() const;

  // ---- index.cpp ----
  /// In one transaction; nothing of it if it throws.
  void add_results(std::span<const NewResult> batch, std::span<const ResultPlace> places);
  void results_of(JobId job, std::optional<std::int32_t> frame,
                  const std::function<void(const IndexedResult&)>& visit) const;
  [[nodiscard]] std::vector<JobId> jobs_with_results() const;
  void forget_results(JobId job);
  /// In one transaction: the results, the checkpoints, and what their results came to.
  void end_job(JobId job);
  /// Segments that hold results.
  [[nodiscard]] std::set<std::uint64_t> segments() const;
  /// … for each job that has some in them.
  [[nodiscard]] std::vector<IndexedFile> indexed_segments() const;

  // ---- checkpoint_index.cpp ----
  /// In one transaction: the checkpoint counts, and what it holds are no results any more. The
  /// number of the one that it takes the place of.
  std::optional<std::uint64_t> put_checkpoint(const Checkpoint& checkpoint);
  [[nodiscard]] std::optional<Checkpoint> checkpoint_of(JobId job, std::int32_t frame) const;
  [[nodiscard]] std::vector<JobId> jobs_with_checkpoints() const;
  [[nodiscard]] std::vector<Checkpoint> checkpoints_of(JobId job) const;
  [[nodiscard]] std::set<std::uint64_t> checkpoint_numbers() const;
  [[nodiscard]] std::vector<IndexedFile> indexed_checkpoints() const;
  [[nodiscard]] std::vector<Tally> tallies_of(JobId job) const;
  /// In one transaction: the record, its spec too; results from pass `passes` on are gone, and no
  /// frame is shortened.
  void extend_job(const JobRecord& record, std::uint32_t passes);
  void forget_job(JobId job);

 private:
  void drop_unused_segments(JobId job);
  void delete_results(JobId job);
  void delete_checkpoints(JobId job);
  void supersede_failed_commits();
  std::int64_t worker_row(const NewResult& result);

  [[nodiscard]] std::vector<IndexedFile> indexed_files(const char* sql) const;

  // Destroyed in reverse: the statements before the connection that they belong to.
  Database writer_;
  mutable std::mutex reading_;
  mutable std::optional<Database> reader_;
  Statement add_result_, add_segment_, add_worker_, find_worker_;
  std::unordered_map<std::string, std::int64_t> worker_rows_;  // looked up alone
};

}  // namespace tessera::server
