#pragma once
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/assets/blob_store.hpp"
#include "server/coordinator/budget.hpp"
#include "server/coordinator/coordinator.hpp"
#include "server/coordinator/crew.hpp"
#include "server/coordinator/event_hub.hpp"
#include "server/coordinator/films.hpp"
#include "server/coordinator/frame_throttle.hpp"
#include "server/coordinator/job_table.hpp"
#include "server/coordinator/offload.hpp"
#include "server/coordinator/picture_cache.hpp"
#include "server/coordinator/result_pipeline.hpp"
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
  boost::asio::awaitable<void> pause(JobId id) override;
  boost::asio::awaitable<void> resume(JobId id) override;
  boost::asio::awaitable<void> change(JobId id, JobChange change) override;
  std::unique_ptr<Subscription> subscribe(std::optional<JobId> job) override;

  // ---- failures.cpp ----
  boost::asio::awaitable<std::vector<FailureRecord>> failures(JobId id) override;

  // ---- pictures.cpp ----
  boost::asio::awaitable<Picture> exr(JobId id, std::int32_t frame) override;
  boost::asio::awaitable<Picture> png(JobId id, std::int32_t frame, double exposure_stops) override;
  boost::asio::awaitable<Picture> tiles(JobId id, std::int32_t frame, std::uint64_t since) override;
  [[nodiscard]] std::optional<std::uint64_t> version(JobId id, std::int32_t frame) const override;

  // ---- workers.cpp ----
  [[nodiscard]] CoordinatorCounters counters() const override { return counters_; }
  [[nodiscard]] std::string trouble() const override { return refused_; }
  [[nodiscard]] std::vector<WorkerView> workers() const override;
  void drain_worker(WorkerId worker) override;
  void quarantine_worker(WorkerId worker, const std::string& reason) override;
  void release_worker(WorkerId worker) override;
  [[nodiscard]] std::uint64_t epoch() const override { return store_->epoch(); }
  WorkerId worker_joined(const WorkerInfo& info, std::shared_ptr<WorkerLink> link) override;
  void worker_heard(WorkerId worker) override;
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
  };

  // ---- impl.cpp ----
  void restore_job(const JobRecord& record);
  /// Of jobs whose end was the last that an earlier run did for them; blocks.
  void forget_results_of_ended();
  /// `log` is the worker's, if it said one.
  void note_failure(const AttemptFailed& failed, const std::string& log);
  /// What the disk does not take is logged and lost: nothing depends on it.
  boost::asio::awaitable<void> keep_failures();
  boost::asio::awaitable<JobId> put_job(JobRecord record);
  boost::asio::awaitable<void> keep_time();
  /// What was not heard while this process stood still was not silence.
  void excuse_workers();
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
  boost::asio::awaitable<void> save(JobRecord record);
  /// Saves the job's record as it is now; gives what went wrong.
  boost::asio::awaitable<std::exception_ptr> save_or_error(JobId id);

  // ---- workers.cpp ----
  void results_durable(std::vector<ArrivedResult> results);
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
  boost::asio::awaitable<void> keep_pictures(JobId id);
  void fail_job(JobId id, const std::string& reason);
  /// Until the store takes it, or stop(). False for the latter.
  boost::asio::awaitable<bool> save_surely(JobRecord record);
  boost::asio::awaitable<void> keep(JobRecord record);
  boost::asio::awaitable<void> let_go(JobId id);
  /// The results of a job that has ended leave the journal. What fails, the next start does again.
  boost::asio::awaitable<void> forget_results(JobId id);

  /// Runs `work` on a lane's thread, or on the writer's, and resumes with what it returns.
  template <class Result>
  boost::asio::awaitable<Result> on(boost::asio::thread_pool& lane, std::function<Result()> work);
  template <class Result>
  boost::asio::awaitable<Result> on_writer(std::function<Result()> work);

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
  Signal files_changed_;  ///< a frame's file is written
  Budget in_flight_;
  std::map<JobId, Job> jobs_;
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
  bool holding_ = false;
  bool stopping_ = false;
  boost::asio::thread_pool pool_;      ///< decodes and folds
  boost::asio::thread_pool previews_;  ///< one thread: PNG and tiles
  boost::asio::thread_pool files_;     ///< one thread: EXR of whole frames, files, bundles
  Films films_;
  ResultPipeline results_;
};

template <class Result>
boost::asio::awaitable<Result> CoordinatorImpl::on(boost::asio::thread_pool& lane,
                                                   std::function<Result()> work) {
  std::function<void(std::function<void()>)> post = [&lane](std::function<void()> todo) {
    boost::asio::post(lane, std::move(todo));
  };
  return offload<Result>(std::move(post), std::move(work));
}

template <class Result>
boost::asio::awaitable<Result> CoordinatorImpl::on_writer(std::function<Result()> work) {
  std::function<void(std::function<void()>)> post = [this](std::function<void()> todo) {
    results_.writer().run(std::move(todo));
  };
  return offload<Result>(std::move(post), std::move(work));
}

}  // namespace tessera::server
