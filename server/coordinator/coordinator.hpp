#pragma once
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/clock.hpp"
#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/job/job_spec.hpp"
#include "common/wire/messages.hpp"
#include "server/schedule/scheduler.hpp"
#include "server/store/records.hpp"

/// The one door to the coordinator's state. It joins scheduler, store and film: sessions bring
/// workers' messages, HTTP brings people's requests. Everything here runs on one executor (the I/O
/// thread); what decodes, encodes, hashes or syncs is done by its pool, and an awaitable resumes on
/// the I/O thread.
namespace tessera::server {

/// How the coordinator speaks to one connected worker; a session implements it. No call blocks or
/// throws.
class WorkerLink {
 public:
  virtual ~WorkerLink() = default;
  virtual void send(wire::Message message) = 0;
  /// The connection is to end; of all calls only worker_left still comes.
  virtual void close(std::string reason) = 0;
  /// While held, nothing is to be read from the worker: more results are here than can be made
  /// durable. Its silence is not its fault then.
  virtual void hold(bool held) = 0;
};

/// What has happened since the coordinator started; numbers only grow.
struct CoordinatorCounters {
  std::uint64_t results_accepted = 0;   ///< durable, the first of their tasks
  std::uint64_t results_duplicate = 0;  ///< of jobs under way, and not needed; told "stale"
  std::uint64_t results_stale = 0;      ///< their jobs have ended, or are not known
  /// Not taken, and why.
  struct Rejected {
    std::uint64_t plan = 0;        ///< of another plan than the job's
    std::uint64_t task = 0;        ///< of a task that the job has not
    std::uint64_t lease = 0;       ///< of a lease that was not granted to that worker
    std::uint64_t statistics = 0;  ///< what it says of itself cannot be
    std::uint64_t tile = 0;        ///< its EXR is not what the task asked for
  } rejected;
  std::uint64_t leases_granted = 0;
  std::uint64_t leases_revoked = 0;  ///< those that expired among them
  std::uint64_t leases_expired = 0;  ///< their workers made no progress for too long
  std::uint64_t store_errors = 0;    ///< times that the disk refused results; they are tried again
  std::uint64_t workers_joined = 0;
  std::uint64_t workers_lost = 0;  ///< left without a word: died, fell silent, were dropped
  /// Of the workers that are connected, as they last said.
  std::uint64_t worker_cache_bytes = 0, worker_cache_most = 0;
  std::uint64_t worker_cache_evictions = 0;  ///< … while they were connected
};

/// A job that was submitted.
struct Submitted {
  JobId job = 0;
  /// The idempotency key was used before, for this job, which was asked for in other words.
  bool of_another_request = false;
};

/// What HTTP and the client show of a job.
struct JobStatus {
  JobView view;
  std::shared_ptr<const JobPlan> plan;
  UnixMillis created = 0, started = 0, finished = 0;  ///< 0: not yet
  double progress = 0;                                ///< 0…1, by samples
  std::uint32_t frames_done = 0;                      ///< frames whose file is written
  double render_seconds = 0;  ///< from the first lease to now if any is out, else to the last fold
  double cpu_seconds = 0;     ///< of the threads that rendered, over all workers and results
  std::int64_t rays = 0;
  std::int64_t rejected_samples = 0;  ///< NaN or Inf, counted as black
  std::uint64_t failures = 0;         ///< attempts at its tasks that gave no result
  struct Share {
    std::string worker;
    std::int64_t samples = 0;
  };
  std::vector<Share> shares;                ///< by worker, most first
  std::vector<std::int64_t> extended_from;  ///< samples asked for before, oldest first
  std::int64_t shortened_from = 0;  ///< samples asked for, where its time was up before; else 0
  /// Frames of several that ended by their noise with fewer samples than those asked for.
  std::uint32_t frames_shortened = 0;
};

/// What is kept, bytes; of films, what is in memory.
struct StorageUse {
  std::uint64_t journal = 0;
  std::uint64_t checkpoints = 0;
  std::uint64_t blobs = 0;
  std::uint64_t pictures = 0;                               ///< final ones
  std::uint64_t blob_cache = 0;                             ///< of the blobs, what no job needs
  std::uint64_t blob_cache_most = 0;                        ///< CoordinatorSettings::blob_cache
  std::uint64_t blobs_evicted = 0, blob_bytes_evicted = 0;  ///< since the start
  std::uint64_t films = 0, films_most = 0;  ///< those too that are on their way to disk
  std::uint64_t disk_most = 0;              ///< CoordinatorSettings::disk_limit
  std::uint64_t disk_free = 0;              ///< on the data folder's file system
  [[nodiscard]] std::uint64_t on_disk() const { return journal + checkpoints + blobs + pictures; }
};

/// What can be changed of a job that has not ended. What is absent stays as it is.
struct JobChange {
  std::optional<int> priority;
  std::optional<int> max_workers;            ///< 0: no limit
  std::optional<std::optional<Rect>> focus;  ///< nothing within: none any more
  [[nodiscard]] bool empty() const { return !priority && !max_workers && !focus; }
};

/// One encoded picture; shared by all who asked for the same version.
struct Picture {
  std::uint64_t version = 0;  ///< grows with every fold of the frame; the ETag
  std::shared_ptr<const std::vector<std::byte>> bytes;
};

/// Something that listeners are told of; `data` is a JSON object.
struct Event {
  std::uint64_t number = 0;
  std::string type;  ///< "job", "frame" (a new version of a picture), "removed" (a job), "worker"
  JobId job = 0;     ///< 0 for events of no job
  std::string data;
};

/// A listener's queue. It holds at most limits::event_backlog events; a listener that is slower
/// loses the oldest, and is told so by an event of type "lost".
class Subscription {
 public:
  virtual ~Subscription() = default;
  /// The next event; nullopt after `wait` without one, or when the coordinator stops.
  virtual boost::asio::awaitable<std::optional<Event>> next(Duration wait) = 0;
};

struct CoordinatorSettings {
  std::filesystem::path data;  ///< the data folder; locked while running
  int pool_threads = 2;
  SchedulerSettings scheduler;  ///< its epoch is set by the store
  std::size_t in_flight =
      256 * limits::MiB;  ///< bytes of results on their way, above which workers are held
  bool durable = true;    ///< false: no fsync (for the benchmark that shows its cost)
  /// Films of unfinished frames in memory, bytes; what is beyond is read back when it is needed. A
  /// job whose single film needs more is refused.
  std::uint64_t film_memory = 1 * limits::GiB;
  /// A job that has ended is forgotten after so long, with its pictures; nullopt: never.
  std::optional<Duration> keep_jobs;
  /// Bytes of the data folder beyond which new jobs and uploads are refused; 0: no limit but the
  /// file system's.
  std::uint64_t disk_limit = 0;
  /// … and so many bytes of the file system are left to the jobs that are here.
  std::uint64_t disk_reserve = 1 * limits::GiB;
  /// Bytes of blobs that no job needs, and of uploads that broke off, beyond which the least
  /// recently used go; none of them where the disk is short of room.
  std::uint64_t blob_cache = 10 * limits::GiB;
  /// … but a blob stays at least so long after it was last used or uploaded.
  Duration blob_grace = std::chrono::hours(6);
  /// Who extends or removes a job waits so long for what is under way with it.
  Duration patience = std::chrono::seconds(20);
  Duration upkeep = std::chrono::seconds(5);  ///< between two looks at all that
};

class Coordinator {
 public:
  /// Opens (or makes) the data folder, reads jobs and index back. Throws Error with the file's
  /// name: locked by another coordinator, damaged, of a newer schema, not writable.
  static std::unique_ptr<Coordinator> open(boost::asio::any_io_executor executor,
                                           CoordinatorSettings settings);
  virtual ~Coordinator() = default;

  // ---- people's side ----
  /// Durable when it resumes. Throws Error{bad_input} for a spec that check() refuses,
  /// Error{conflict} if the bundle or a blob that it names is not in the blob store, Error{no_room}
  /// where the disk is full or holds as much as it may.
  virtual boost::asio::awaitable<JobId> submit(JobSpec spec) = 0;
  /// The same under an idempotency key. Where it was used before, also before a restart, no job is
  /// made, and the one that was is given.
  virtual boost::asio::awaitable<Submitted> submit_once(JobSpec spec,
                                                        std::string idempotency_key) = 0;
  /// The newest attempts at the job's tasks that gave no result (Store::failures_kept), newest
  /// first.
  virtual boost::asio::awaitable<std::vector<FailureRecord>> failures(JobId id) = 0;
  [[nodiscard]] virtual std::vector<JobStatus> jobs() const = 0;
  [[nodiscard]] virtual std::optional<JobStatus> job(JobId id) const = 0;
  /// Each throws Error{not_found}, or Error{conflict} where the job's state does not allow it.
  virtual boost::asio::awaitable<void> cancel(JobId id) = 0;
  /// Nothing is left of a job that has ended, nor of its pictures. Durable when it resumes.
  virtual boost::asio::awaitable<void> purge(JobId id) = 0;
  virtual boost::asio::awaitable<void> pause(JobId id) = 0;
  virtual boost::asio::awaitable<void> resume(JobId id) = 0;
  /// All of it or, if anything of it is wrong (Error{bad_input}), nothing.
  virtual boost::asio::awaitable<void> change(JobId id, JobChange change) = 0;
  /// The job, under way or done, goes on to so many samples of each pixel; its result has the bits
  /// of a job that was submitted with them. Durable when it resumes. Also throws Error{bad_input}
  /// if it has that many already, or the limits do not allow it.
  virtual boost::asio::awaitable<void> extend(JobId id, std::int64_t samples) = 0;
  /// Why new jobs, or an upload of `more` bytes, are refused at present: the disk; empty: they are
  /// not.
  [[nodiscard]] virtual std::string lacks_room(std::uint64_t more) const = 0;
  [[nodiscard]] virtual StorageUse storage() const = 0;

  // ---- pictures ----
  /// The frame as far as it is folded, whole and consistent. Throws Error{not_found}.
  virtual boost::asio::awaitable<Picture> exr(JobId id, std::int32_t frame) = 0;
  virtual boost::asio::awaitable<Picture> png(JobId id, std::int32_t frame,
                                              double exposure_stops) = 0;
  /// The tiles whose last fold is newer than version `since`, in the binary form that
  /// server/film/README.md describes.
  virtual boost::asio::awaitable<Picture> tiles(JobId id, std::int32_t frame,
                                                std::uint64_t since) = 0;
  /// The present version without encoding anything.
  [[nodiscard]] virtual std::optional<std::uint64_t> version(JobId id,
                                                             std::int32_t frame) const = 0;
  /// Samples of each pixel that the frame has when it is done, at most while it is not.
  [[nodiscard]] virtual std::optional<std::int64_t> samples(JobId id, std::int32_t frame) const = 0;

  /// Since the start.
  [[nodiscard]] virtual CoordinatorCounters counters() const = 0;
  /// Why results cannot be made durable at present (a full disk); empty: they can.
  [[nodiscard]] virtual std::string trouble() const = 0;

  // ---- listening ----
  /// Events of one job, or of all.
  virtual std::unique_ptr<Subscription> subscribe(std::optional<JobId> job) = 0;

  // ---- workers ----
  [[nodiscard]] virtual std::vector<WorkerView> workers() const = 0;
  /// It finishes what it holds, and leaves.
  virtual void drain_worker(WorkerId worker) = 0;
  /// Workers of this name are granted nothing until they are released, those too that come later,
  /// also after a restart; what they hold is revoked. Durable when it resumes.
  virtual boost::asio::awaitable<void> quarantine(std::string name, std::string reason) = 0;
  /// Nothing happens if they are not quarantined. Durable when it resumes.
  virtual boost::asio::awaitable<void> release(std::string name) = 0;
  /// By name; those too of which no worker is here.
  [[nodiscard]] virtual std::vector<Quarantine> quarantines() const = 0;
  [[nodiscard]] virtual std::uint64_t epoch() const = 0;

  // ---- sessions' side: called on the I/O thread ----
  /// `link` must outlive the matching worker_left.
  virtual WorkerId worker_joined(const WorkerInfo& info, std::shared_ptr<WorkerLink> link) = 0;
  virtual void worker_heard(WorkerId worker) = 0;
  /// Nothing is read from it because it is held: neither silence nor want of progress is its fault.
  virtual void excuse_worker(WorkerId worker) = 0;
  /// Any message after hello but a result.
  virtual void worker_said(WorkerId worker, wire::Message message) = 0;
  /// `exr` is the body. The answer (accepted, stale, rejected) is sent over the link when it is
  /// known.
  virtual void worker_result(WorkerId worker, wire::Result result, std::vector<std::byte> exr) = 0;
  virtual void worker_left(WorkerId worker, bool clean) = 0;

  /// Stops the timers, finishes what is being journaled, closes the links. Call before the executor
  /// stops.
  virtual boost::asio::awaitable<void> stop() = 0;
};

}  // namespace tessera::server
