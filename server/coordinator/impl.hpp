#pragma once
#include <atomic>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/assets/blob_store.hpp"
#include "server/coordinator/at_work.hpp"
#include "server/coordinator/budget.hpp"
#include "server/coordinator/coordinator.hpp"
#include "server/coordinator/crew.hpp"
#include "server/coordinator/event_hub.hpp"
#include "server/coordinator/film_memory.hpp"
#include "server/coordinator/films.hpp"
#include "server/coordinator/frame_throttle.hpp"
#include "server/coordinator/job_content.hpp"
#include "server/coordinator/job_table.hpp"
#include "server/coordinator/noise_look.hpp"
#include "server/coordinator/offload.hpp"
#include "server/coordinator/picture_cache.hpp"
#include "server/coordinator/quarantine_table.hpp"
#include "server/coordinator/result_pipeline.hpp"
#include "server/coordinator/whole_films.hpp"
#include "server/store/store.hpp"

/// The real coordinator. Its members are used on the I/O thread alone, unless they say otherwise;
/// README.md draws the threads.
namespace tessera::server {

class CoordinatorImpl : public Coordinator {
 public:
  CoordinatorImpl(boost::asio::any_io_executor io, CoordinatorSettings settings,
                  std::unique_ptr<Store> store);
  ~CoordinatorImpl() override;

  // ---- people.cpp ----
  boost::asio::awaitable<JobId> submit(JobSpec spec) override;
  boost::asio::awaitable<Submitted> submit_once(JobSpec spec, std::string idempotency_key) override;
  [[nodiscard]] std::vector<JobStatus> jobs() const override;
  [[nodiscard]] std::optional<JobStatus> job(JobId id) const override;
  boost::asio::awaitable<void> cancel(JobId id) override;
  boost::asio::awaitable<void> purge(JobId id) override;
  boost::asio::awaitable<void> pause(JobId id) override;
  boost::asio::awaitable<void> resume(JobId id) override;
  boost::asio::awaitable<void> change(JobId id, JobChange change) override;
  // ---- extend.cpp ----
  boost::asio::awaitable<void> extend(JobId id, std::int64_t samples) override;
  // ---- people.cpp ----
  std::unique_ptr<Subscription> subscribe(std::optional<JobId> job) override;

  // ---- failures.cpp ----
  boost::asio::awaitable<std::vector<FailureRecord>> failures(JobId id) override;

  // ---- room.cpp ----
  [[nodiscard]] std::string lacks_room(std::uint64_t more) const override;
  [[nodiscard]] StorageUse storage() const override;

  // ---- pictures.cpp ----
  boost::asio::awaitable<Picture> exr(JobId id, std::int32_t frame) override;
  boost::asio::awaitable<Picture> png(JobId id, std::int32_t frame, double exposure_stops) override;
  boost::asio::awaitable<Picture> tiles(JobId id, std::int32_t frame, std::uint64_t since) override;
  [[nodiscard]] std::optional<std::uint64_t> version(JobId id, std::int32_t frame) const override;
  [[nodiscard]] std::optional<std::int64_t> samples(JobId id, std::int32_t frame) const override;

  // ---- workers.cpp ----
  [[nodiscard]] CoordinatorCounters counters() const override { return counters_; }
  [[nodiscard]] std::string trouble() const override { return refused_; }
  [[nodiscard]] std::vector<WorkerView> workers() const override;
  void drain_worker(WorkerId worker) override;
  boost::asio::awaitable<void> quarantine(std::string name, std::string reason) override;
  boost::asio::awaitable<void> release(std::string name) override;
  [[nodiscard]] std::vector<Quarantine> quarantines() const override { return quarantines_.all(); }
  [[nodiscard]] std::uint64_t epoch() const override { return store_->epoch(); }
  WorkerId worker_joined(const WorkerInfo& info, std::shared_ptr<WorkerLink> link) override;
  void worker_heard(WorkerId worker) override;
  void excuse_worker(WorkerId worker) override;
  void worker_said(WorkerId worker, wire::Message message) override;
  void worker_result(WorkerId worker, wire::Result result, std::vector<std::byte> exr) override;
  void worker_left(WorkerId worker, bool clean) override;

  // ---- impl.cpp ----
  /// Gives scheduler and films what the store holds; blocks.
  void restore();
  /// Starts the clock.
  void start();
  boost::asio::awaitable<void> stop() override;

 private:
  struct Worker {
    WorkerInfo info;
    std::shared_ptr<WorkerLink> link;
    std::set<JobId> told;  ///< jobs whose spec was sent over this connection
    std::optional<wire::CacheUse> cache;
  };

  [[nodiscard]] AtWork at_work(JobId job) { return {alive_, known(job), files_changed_}; }

  // ---- impl.cpp ----
  void restore_job(const JobRecord& record);
  /// Gives films and scheduler what is kept of a job that they do not know yet.
  void take_in(Job& job, const JobContent& content);
  /// The films' part of that. `also_written`: of frames too that have a file.
  std::map<std::int32_t, FrameFilm*> restore_films(const Job& job, const JobContent& content,
                                                   bool also_written);
  /// Jobs whose end was the last that an earlier run did for them; blocks.
  void look_at_ended();
  /// `log` is the worker's, if it said one.
  void note_failure(const AttemptFailed& failed, const std::string& log);
  /// What the disk does not take is logged and lost: nothing depends on it.
  boost::asio::awaitable<void> keep_failures();
  boost::asio::awaitable<JobId> put_job(JobRecord record);
  boost::asio::awaitable<void> keep_time();
  /// What was not heard while this process stood still was neither silence nor want of progress.
  void excuse_workers(Duration late);
  void results_refused(const std::string& reason);
  void tick();
  [[nodiscard]] std::optional<Instant> next_deadline() const;
  void wake_in_time();
  void perform(const Actions& actions);
  void perform_one(const GrantLease& grant);
  void perform_one(const RevokeLeases& revoke);
  void perform_one(const DropWorker& drop);
  void perform_one(const JobFailed& failed);
  void perform_one(const AttemptFailed& failed);
  void perform_one(const WorkerQuarantined& barred);
  void perform_one(const JobShortened& shortened);
  void perform_one(const FrameShortened& shortened);
  void perform_one(const MeasureNoise& asked);
  void perform_one(const JobFinished& finished);
  void perform_one(const FrameFinished& finished);
  void tile_folded(JobId id, std::int32_t frame, std::uint32_t tile, std::uint32_t passes);
  Job* find(JobId id);
  [[nodiscard]] const Job* find(JobId id) const;
  /// Throws Error{not_found}.
  Job& known(JobId id);
  [[nodiscard]] JobStatus status_of(const Job& job) const;
  void tell_job(JobId id);
  void tell_frames(const std::vector<FrameThrottle::Frame>& frames);

  // ---- people.cpp ----
  /// Throws Error{not_found}, or Error{conflict} if the job has ended.
  Job& live(JobId id);
  /// Waits until no other change of the job is under way. Throws as live() does.
  boost::asio::awaitable<void> until_unchanging(JobId id);
  /// Saves the job's record as it is now; gives what went wrong. No other way leads to the store:
  /// so an older record never comes after a newer one.
  boost::asio::awaitable<std::exception_ptr> save_or_error(JobId id);

  // ---- extend.cpp ----
  /// Throws Error if the job cannot go on to so many samples.
  void check_extension(const Job& job, std::int64_t samples) const;
  void check_it_goes_on(const Job& job) const;
  struct Extension {
    enum class Step { waiting, reading, changing } step = Step::waiting;
    bool over = false;
    std::exception_ptr error;
  };
  boost::asio::awaitable<void> run_extension(JobId id, std::int64_t samples,
                                             std::shared_ptr<Extension> outcome);
  /// Nothing is under way with the job, and what the store holds of it can be read; else throws,
  /// and nothing of it has changed.
  boost::asio::awaitable<void> until_extendable(JobId id, std::shared_ptr<Extension> outcome);
  boost::asio::awaitable<void> until_quiet(JobId id);
  [[nodiscard]] bool is_busy(JobId id) const;
  boost::asio::awaitable<void> extend_checked(JobId id, std::int64_t samples);
  /// What the store holds of the job, however often it takes, or until stop(), which throws.
  boost::asio::awaitable<JobContent> read_surely(JobId id);
  /// The job begins anew with this record and what the store holds of it.
  boost::asio::awaitable<void> reopen(JobRecord record);

  // ---- checkpoints.cpp ----
  /// Has a checkpoint made of the frame if enough of it is in the journal.
  void compact_in_time(JobId id, std::int32_t frame);
  boost::asio::awaitable<void> compact(JobId id, std::int32_t frame);
  boost::asio::awaitable<void> make_checkpoint(JobId id, std::int32_t frame);
  boost::asio::awaitable<void> put_checkpoint(Checkpoint made);
  boost::asio::awaitable<bool> try_to_put(Checkpoint made);
  /// One that was put in vain, and will not be again.
  boost::asio::awaitable<void> discard_checkpoint(Checkpoint made);
  /// The frame's file stands: its regular passes are kept in a checkpoint, of `film` if that is at
  /// hand, else of what is on disk; however often it takes, unless the job is unwanted.
  boost::asio::awaitable<void> settle_frame(JobId id, std::int32_t frame, WholeFilm film);
  /// `made` is kept for the next try, if the store does not take it.
  boost::asio::awaitable<bool> try_to_settle(JobId id, std::int32_t frame,
                                             std::shared_ptr<const FilmSnapshot> film,
                                             std::shared_ptr<std::optional<Checkpoint>> made);
  /// Finished frames whose results are still in the journal after a start.
  void settle_what_is_left(Job& job, const JobContent& content);
  void settle_all(const Job& job);
  /// The job is done: once its frames are settled, results that are left go.
  boost::asio::awaitable<void> forget_settled(JobId id);

  // ---- room.cpp ----
  /// Begins to look after the data folder; blocks if what is in it counts for a limit.
  void begin_house();
  boost::asio::awaitable<void> keep_house();
  boost::asio::awaitable<void> collect_blobs();
  boost::asio::awaitable<void> measure(bool walk);
  /// At a start: folders of jobs that were being forgotten go, or are the job's again if the store
  /// did not come to it. Those of jobs that no record knows stay; no new job gets their numbers.
  void settle_job_folders(const std::vector<JobRecord>& records);
  /// Any thread. `use` as it was; `walk`: also what is kept beside the store.
  [[nodiscard]] StorageUse look_at_disk(StorageUse use, bool walk) const;

  // ---- forget.cpp ----
  boost::asio::awaitable<void> forget_expired();
  /// The job has ended, and nothing is under way that ends or keeps something of it.
  boost::asio::awaitable<void> forget_job(JobId id, std::string why);
  /// Until nothing is under way with the job that has ended; throws if that takes too long.
  boost::asio::awaitable<void> until_at_rest(JobId id);

  // ---- quarantines.cpp ----
  QuarantineTable::Hooks quarantine_hooks();
  boost::asio::awaitable<void> save_quarantine(std::string name, std::optional<Quarantine> kept);
  void worker_released(const std::string& name);

  // ---- workers.cpp ----
  void results_durable(std::vector<ArrivedResult> results);
  void end_arriving(Job& job);
  void forget_late_results(JobId id);
  void result_invalid(const ArrivedResult& result, const std::string& reason);
  /// Why the scheduler rejects it, in words; counted.
  std::string refuse(const wire::Result& result, const Job* job);
  void send(WorkerId worker, wire::Message message);
  void hold_or_release();

  // ---- pictures.cpp ----
  boost::asio::awaitable<Picture> picture(PictureKey key);
  boost::asio::awaitable<void> make_picture(PictureKey key, PictureCache::Done done);
  boost::asio::awaitable<Picture> produce(PictureKey key);
  image::Metadata metadata_for(const Job& job, std::int32_t frame) const;

  // ---- ends.cpp ----
  /// Writes the frame's final EXR, however often it takes, then lets its film go.
  boost::asio::awaitable<void> finish_frame(JobId id, std::int32_t frame);
  boost::asio::awaitable<bool> write_frame(JobId id, std::int32_t frame);
  /// The job is done, and its files are written: makes that durable.
  boost::asio::awaitable<void> finish_job(JobId id);
  /// The job has failed or is cancelled: makes that durable (unless it is), keeps its pictures so
  /// far, lets go.
  boost::asio::awaitable<void> abandon_job(JobId id, std::string state, std::string error);
  /// True if all are written that it has films of.
  boost::asio::awaitable<bool> keep_pictures(JobId id);
  /// The film has more samples than the picture of the samples before the job was extended.
  boost::asio::awaitable<bool> surpasses_its_file(JobId id, std::int32_t frame);
  void fail_job(JobId id, const std::string& reason);
  /// Until the store takes the job's record, at each attempt as it is then. False if the job is
  /// forgotten or the coordinator stops before that.
  boost::asio::awaitable<bool> save_surely(JobId id);
  /// The same of the samples that a frame has which ended by its noise, or that it did not.
  boost::asio::awaitable<bool> save_shortened_surely(JobId id, std::int32_t frame);
  boost::asio::awaitable<void> keep_end_of(JobId id, std::int32_t frame);
  /// The job's record has changed, or was taken back: sees to it that the store says the same.
  void keep(Job& job);
  boost::asio::awaitable<void> keep_record(JobId id);
  void let_go(JobId id);

  // ---- owed.cpp ----
  boost::asio::awaitable<void> keep_owed_pictures();
  boost::asio::awaitable<void> write_owed(JobId id);
  /// `kept`: its pictures are written. Decides what becomes of the rest.
  boost::asio::awaitable<void> settle_what_is_owed(JobId id, bool kept);
  /// The results of a job that failed or was cancelled leave the journal, and its checkpoints are
  /// deleted.
  boost::asio::awaitable<void> forget_results(JobId id);
  /// Store::forget_results or Store::end_job. What fails, the next start does again.
  boost::asio::awaitable<void> drop_results(JobId id, void (Store::*drop)(JobId));

  /// Runs `work` on the writer's thread, and resumes with what it returns.
  template <class Result>
  boost::asio::awaitable<Result> on_writer(std::function<Result()> work) {
    std::function<void(std::function<void()>)> post = [this](std::function<void()> todo) {
      results_.writer().run(std::move(todo));
    };
    return offload<Result>(std::move(post), std::move(work));
  }
  boost::asio::awaitable<void> on_writer(std::function<void()> work) {
    const std::function<char()> whole = [work = std::move(work)] {
      work();
      return char{};
    };
    co_await on_writer<char>(whole);
  }

  boost::asio::any_io_executor io_;
  CoordinatorSettings settings_;
  std::unique_ptr<Store> store_;  ///< const calls from any thread, others from the writer's
  assets::BlobStore blobs_;       ///< any thread
  Scheduler scheduler_;
  EventHub hub_;
  FrameThrottle frame_news_;
  FrameThrottle job_news_;  ///< each job as its frame 0
  PictureCache pictures_;
  Crew crew_;
  Signal files_changed_;  ///< a frame's file is written, or something that others wait for
  WholeFilms whole_films_;
  Budget settling_;  ///< bytes of films that are on their way to their checkpoints
  Budget in_flight_;
  std::map<JobId, Job> jobs_;
  QuarantineTable quarantines_;
  std::unordered_map<WorkerId, Worker> workers_;
  boost::asio::steady_timer clock_;
  Instant armed_ = Instant::max();
  CoordinatorCounters counters_;
  std::map<JobId, std::vector<FailureRecord>> new_failures_;  ///< not kept yet
  bool keeping_failures_ = false;
  struct Request {
    JobId job = 0;  ///< 0: being submitted
    std::string fingerprint;
  };
  std::map<std::string, Request> requests_;  ///< by idempotency key
  std::string refused_;                      ///< why the disk takes no results
  StorageUse measured_;
  std::uint64_t reserve_ = 0;  ///< bytes of the file system
  bool collect_soon_ = false;  ///< a job needs its blobs no more
  bool compacting_ = false;    ///< a frame that is under way is being checkpointed
  bool holding_ = false;
  bool stopping_ = false;
  boost::asio::thread_pool pool_;         ///< decodes and folds
  boost::asio::thread_pool previews_;     ///< one thread: PNG and tiles
  boost::asio::thread_pool files_;        ///< one thread: EXR of whole frames, files, bundles
  boost::asio::thread_pool checkpoints_;  ///< one thread
  boost::asio::thread_pool upkeep_;       ///< one thread
  std::atomic<bool> stopped_{false};      ///< for what is long on other threads
  Films films_;
  NoiseLooks noise_looks_;
  ResultPipeline results_;
  std::shared_ptr<const char> alive_ = std::make_shared<const char>();  ///< as long as this is
};

}  // namespace tessera::server
