#include "server/store/store.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "server/store/index.hpp"
#include "server/store/journal.hpp"

namespace tessera::server {
namespace {

std::unique_ptr<DiskFile> held(Disk& disk, const std::filesystem::path& folder, bool durable) {
  make_folders(disk, folder, durable);
  make_folder(disk, folder / "journal", durable);
  make_folder(disk, folder / "checkpoints", durable);
  const std::filesystem::path file = folder / "lock";
  auto lock = disk.hold(file);
  if (!lock) {
    const auto reader = disk.open(file);
    std::string holder(std::min<std::size_t>(reader->size(), 20), '\0');
    reader->read_at(std::as_writable_bytes(std::span(holder)), 0);
    throw Error(ErrorKind::conflict,
                fmt::format("data folder {} is in use by another coordinator (process {})",
                            folder.string(), holder.empty() ? "unknown" : holder));
  }
  const std::string process = std::to_string(::getpid());
  lock->truncate(0);
  lock->write_at(std::as_bytes(std::span(process)), 0);
  return lock;
}

/// What a process that was killed had written to the database's log, SQLite takes as kept: it has
/// to be, before anything is built on it.
std::filesystem::path settled_database(Disk& disk, const std::filesystem::path& folder,
                                       bool durable) {
  std::filesystem::path file = folder / "tessera.db";
  if (durable)
    for (const char* log : {"-journal", "-wal"}) settle(disk, file.string() + log);
  return file;
}

std::array<std::uint8_t, 16> key_from(const std::string& hex) {
  std::array<std::uint8_t, 16> key{};
  const auto whole = Digest::from_hex(hex + hex);
  if (!whole) throw Error(ErrorKind::failed, "the database is damaged: its grant key is no key");
  std::copy_n(whole->bytes.begin(), key.size(), key.begin());
  return key;
}

}  // namespace

struct Store::State {
  State(const std::filesystem::path& where, const StoreSettings& settings)
      : folder(where),
        disk(settings.disk),
        lock(held(*disk, where, settings.durable)),
        index(settled_database(*disk, where, settings.durable), settings.durable,
              disk->sqlite_vfs()),
        journal(*disk, where / "journal", settings.durable, settings.segment_bytes),
        checkpoints(*disk, where / "checkpoints", settings.durable) {}

  /// Looks for what is lacking, and removes what nothing names. Also keeps new files from taking
  /// the numbers of those that are lacking: rows name them.
  void settle_files() {
    for (const IndexedFile& file : index.indexed_segments()) {
      journal.skip(file.number);
      look_at(file, "results", journal.path_of(file.number), look_at_segment(file.number));
    }
    auto found = checkpoints.take_found();
    for (const IndexedFile& file : index.indexed_checkpoints()) {
      checkpoints.skip(file.number);
      look_at(file, "the film", checkpoints.path_of(file.number), found[file.number]);
      found.erase(file.number);
    }
    for (const auto& [job, what] : damage)
      log::error("job {} is damaged, all others are not: {}", job, what);
    remove_dead_segments();
    for (const auto& [number, unnamed] : found) checkpoints.remove(number);
  }
  [[nodiscard]] CheckpointFiles::Found look_at_segment(std::uint64_t number) const {
    CheckpointFiles::Found found;
    try {
      found.bytes = journal.size_of(number);
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::not_found) found.unseen = error.what();
    }
    return found;
  }
  void look_at(const IndexedFile& file, const char* what, const std::filesystem::path& path,
               const CheckpointFiles::Found& found) {
    if (found.unseen.empty() && found.bytes >= file.bytes) return;
    std::string& said = damage[file.job];
    if (!said.empty()) return;  // the first tells what to look for
    said = found.unseen.empty()
               ? fmt::format(
                     "{} is lacking or too short: it has {} bytes, and {} of job {} "
                     "should reach to {}",
                     path.string(), found.bytes, what, file.job, file.bytes)
               : fmt::format("{}; it should have {} of job {}", found.unseen, what, file.job);
  }
  [[nodiscard]] std::vector<std::uint64_t> checkpoints_of(JobId job) const {
    std::vector<std::uint64_t> numbers;
    for (const Checkpoint& held : index.checkpoints_of(job)) numbers.push_back(held.number);
    return numbers;
  }
  void remove_dead_segments() {
    const auto needed = index.segments();
    for (const std::uint64_t segment : journal.segments()) {
      if (!needed.contains(segment)) journal.remove(segment);
    }
  }
  /// What a commit has left over, these checkpoints too. The commit stands whatever becomes of it:
  /// nothing of this may reach the caller, who would take the change for one that was not made.
  void clean_up(std::span<const std::uint64_t> numbers = {}) noexcept {
    try {
      for (const std::uint64_t number : numbers) checkpoints.remove(number);
      if (!doubtful.empty()) {
        const auto needed = index.checkpoint_numbers();
        for (const std::uint64_t number : doubtful)
          if (!needed.contains(number)) checkpoints.remove(number);
        doubtful.clear();
      }
      remove_dead_segments();
    } catch (const std::exception& error) {
      log::warn("files that are needed no more are not all removed: {}; the next start tries again",
                error.what());
    }
  }

  std::filesystem::path folder;
  std::shared_ptr<Disk> disk;
  std::unique_ptr<DiskFile> lock;
  Index index;
  Journal journal;
  CheckpointFiles checkpoints;
  /// Checkpoints that were discarded after their commit failed. It may yet come to light, until
  /// another one has succeeded.
  std::vector<std::uint64_t> doubtful;
  std::array<std::uint8_t, 16> key{};
  std::uint64_t epoch = 0;
  std::map<JobId, std::string> damage;
};

Store::Store(std::unique_ptr<State> state) : state_(std::move(state)) {}
Store::~Store() = default;

std::unique_ptr<Store> Store::open(const std::filesystem::path& folder,
                                   const StoreSettings& settings) {
  auto state = std::make_unique<State>(folder, settings);
  state->settle_files();
  state->key = key_from(state->index.grant_key());
  state->epoch = state->index.next_epoch();
  if (settings.durable) state->disk->sync_folder(folder);  // the database's name in it
  return std::unique_ptr<Store>(new Store(std::move(state)));
}

const std::filesystem::path& Store::folder() const { return state_->folder; }
std::uint64_t Store::epoch() const { return state_->epoch; }
const std::map<JobId, std::string>& Store::damage() const { return state_->damage; }
const std::array<std::uint8_t, 16>& Store::grant_key() const { return state_->key; }

JobId Store::put_job(const JobRecord& record) { return state_->index.put_job(record); }
void Store::skip_jobs(JobId last) { state_->index.skip_jobs(last); }
void Store::update_job(const JobRecord& record) { state_->index.update_job(record); }
void Store::shorten_frame(JobId job, std::int32_t frame, std::int64_t samples) {
  state_->index.shorten_frame(job, frame, samples);
}
void Store::unshorten_frame(JobId job, std::int32_t frame) {
  state_->index.unshorten_frame(job, frame);
}
std::vector<JobRecord> Store::list_jobs() const { return state_->index.list_jobs(); }

void Store::add_failures(JobId job, std::span<const FailureRecord> failures) {
  state_->index.add_failures(job, failures, failures_kept);
}
std::vector<FailureRecord> Store::failures(JobId job) const { return state_->index.failures(job); }
std::map<JobId, std::uint64_t> Store::failure_counts() const {
  return state_->index.failure_counts();
}

void Store::put_quarantine(const Quarantine& quarantine) {
  state_->index.put_quarantine(quarantine);
}
void Store::remove_quarantine(const std::string& name) { state_->index.remove_quarantine(name); }
std::vector<Quarantine> Store::quarantines() const { return state_->index.quarantines(); }

std::vector<ResultPlace> Store::append_results(std::span<const NewResult> batch) {
  if (batch.empty()) return {};
  std::vector<ResultPlace> places = state_->journal.append(batch);
  try {
    state_->index.add_results(batch, places);
  } catch (const DatabaseError& error) {
    // Where the commit itself may have reached the disk, what it names must stay as it is.
    if (error.disk_full()) {
      state_->journal.undo();
    } else {
      state_->journal.seal();
    }
    throw;
  }
  return places;
}

void Store::results_of(JobId job, const std::function<void(const IndexedResult&)>& visit) const {
  state_->index.results_of(job, std::nullopt, visit);
}

void Store::results_of(JobId job, std::int32_t frame,
                       const std::function<void(const IndexedResult&)>& visit) const {
  state_->index.results_of(job, frame, visit);
}

std::vector<JobId> Store::jobs_with_results() const { return state_->index.jobs_with_results(); }

StoredResult Store::read_result(const ResultPlace& place) const {
  return state_->journal.read(place);
}

void Store::extend_job(const JobRecord& record, std::uint32_t passes) {
  state_->index.extend_job(record, passes);
  state_->clean_up();
}

void Store::forget_results(JobId job) {
  state_->index.forget_results(job);
  state_->clean_up();
}

void Store::end_job(JobId job) {
  const std::vector<std::uint64_t> numbers = state_->checkpoints_of(job);
  state_->index.end_job(job);
  state_->clean_up(numbers);
}

void Store::forget_job(JobId job) {
  const std::vector<std::uint64_t> numbers = state_->checkpoints_of(job);
  state_->index.forget_job(job);
  state_->clean_up(numbers);
}

std::unique_ptr<CheckpointWriter> Store::begin_checkpoint(JobId job, std::int32_t frame) const {
  return state_->checkpoints.begin(job, frame);
}

void Store::put_checkpoint(const Checkpoint& checkpoint) {
  const auto before = state_->index.put_checkpoint(checkpoint);
  if (before) {
    state_->clean_up({&*before, 1});
  } else {
    state_->clean_up();
  }
}

void Store::discard_checkpoint(const Checkpoint& checkpoint) {
  state_->doubtful.push_back(checkpoint.number);
}

std::optional<Checkpoint> Store::checkpoint_of(JobId job, std::int32_t frame) const {
  return state_->index.checkpoint_of(job, frame);
}

std::vector<JobId> Store::jobs_with_checkpoints() const {
  return state_->index.jobs_with_checkpoints();
}

std::vector<Checkpoint> Store::checkpoints_of(JobId job) const {
  return state_->index.checkpoints_of(job);
}

std::vector<std::byte> Store::read_checkpoint(const CheckpointPlace& place) const {
  return state_->checkpoints.read(place);
}

std::vector<Tally> Store::tallies_of(JobId job) const { return state_->index.tallies_of(job); }

std::uint64_t Store::journal_bytes() const { return state_->journal.bytes(); }
std::uint64_t Store::checkpoint_bytes() const { return state_->checkpoints.bytes(); }

}  // namespace tessera::server
