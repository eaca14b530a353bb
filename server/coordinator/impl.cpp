#include "server/coordinator/impl.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "server/coordinator/frame_file.hpp"
#include "server/film/film_tile_bytes.hpp"

namespace tessera::server {

namespace {

constexpr Duration frame_news_spacing = std::chrono::milliseconds(83);  // 12 a second
constexpr Duration job_news_spacing = std::chrono::milliseconds(250);
constexpr Duration tick_least = std::chrono::milliseconds(1);
constexpr Duration held_step = std::chrono::milliseconds(20);
constexpr Duration stood_still = std::chrono::seconds(1);
constexpr Duration pulse = std::chrono::milliseconds(500);  // the clock's, while there are workers
constexpr std::size_t pictures_kept = 256 * limits::MiB;

Instant now() { return std::chrono::steady_clock::now(); }

SchedulerSettings scheduler_settings(const CoordinatorSettings& settings, const Store& store) {
  SchedulerSettings out = settings.scheduler;
  out.epoch = store.epoch();
  out.grant_key = store.grant_key();
  return out;
}

NewResult new_result(const ArrivedResult& result) {
  return {result.info, result.worker_name, result.worker_build, *result.exr};
}

}  // namespace

std::unique_ptr<Coordinator> Coordinator::open(boost::asio::any_io_executor executor,
                                               CoordinatorSettings settings) {
  StoreSettings store_settings;
  store_settings.durable = settings.durable;
  auto store = Store::open(settings.data, store_settings);
  auto coordinator =
      std::make_unique<CoordinatorImpl>(executor, std::move(settings), std::move(store));
  coordinator->restore();
  coordinator->start();
  return coordinator;
}

CoordinatorImpl::CoordinatorImpl(boost::asio::any_io_executor io, CoordinatorSettings settings,
                                 std::unique_ptr<Store> store)
    : io_(std::move(io)),
      settings_(std::move(settings)),
      store_(std::move(store)),
      blobs_(settings_.data / "blobs", settings_.durable),
      scheduler_(scheduler_settings(settings_, *store_)),
      hub_(io_),
      frame_news_(frame_news_spacing),
      job_news_(job_news_spacing),
      pictures_(io_, pictures_kept),
      crew_(io_),
      files_changed_(io_),
      whole_films_(settings_.film_memory, files_changed_),
      quarantines_(crew_, files_changed_, quarantine_hooks()),
      clock_(io_),
      pool_(static_cast<std::size_t>(std::max(1, settings_.pool_threads))),
      previews_(1),
      files_(1),
      checkpoints_(1),
      upkeep_(1),
      films_(
          io_, pool_, settings_.pool_threads, crew_, settings_.film_memory,
          {[this](const ResultPlace& place, const image::TileExpectation& expected) {
             return decode(
                 std::make_shared<const std::vector<std::byte>>(store_->read_result(place).exr),
                 expected);
           },
           [this](const CheckpointPlace& place, const Rect& window, const image::Layout& layout) {
             return film_tile_from(store_->read_checkpoint(place), window, layout);
           }},
          {[this](JobId job, std::int32_t frame, std::uint32_t tile, std::uint32_t passes) {
             tile_folded(job, frame, tile, passes);
           },
           [this](JobId job, const std::string& reason) { fail_job(job, reason); },
           [this] { hold_or_release(); }}),
      noise_looks_(films_, whole_films_, files_changed_, crew_, pool_),
      results_(io_, pool_, settings_.pool_threads, crew_,
               [this](std::vector<ArrivedResult>& group) {
                 std::vector<NewResult> batch;
                 batch.reserve(group.size());
                 for (const ArrivedResult& result : group) batch.push_back(new_result(result));
                 return store_->append_results(batch);
               },
               {[this](std::vector<ArrivedResult> results) { results_durable(std::move(results)); },
                [this](const ArrivedResult& result, const std::string& reason) {
                  ++counters_.rejected.tile;
                  if (Job* job = find(result.info.job)) end_arriving(*job);
                  result_invalid(result, reason);
                },
                [this](const std::string& reason) { results_refused(reason); }}) {}

CoordinatorImpl::~CoordinatorImpl() {
  alive_.reset();
  // After stop() there is nothing left to do. Without it this is as if the process had been killed:
  // what is on the pools is dropped, and what they posted must not run any more.
  stopped_ = true;
  for (boost::asio::thread_pool* lane : {&pool_, &previews_, &files_, &checkpoints_, &upkeep_}) {
    lane->stop();
    lane->join();
  }
  results_.writer().stop();
}

// ---- start and stop ----

void CoordinatorImpl::start() {
  crew_.start("the coordinator's clock", keep_time());
  crew_.start("pictures of ended jobs", keep_owed_pictures());
  begin_house();
}

boost::asio::awaitable<void> CoordinatorImpl::stop() {
  stopping_ = true;
  stopped_ = true;
  clock_.cancel();
  crew_.stop();
  files_changed_.notify();
  std::vector<std::shared_ptr<WorkerLink>> links;
  for (const auto& [id, worker] : workers_) links.push_back(worker.link);
  for (const auto& link : links) link->close("the coordinator stops");
  results_.writer().give_up();
  co_await crew_.ended();
  // The writer finishes what is queued; what it says about that is handled before this resumes.
  const std::function<char()> finish_writing = [this] {
    results_.writer().stop();
    return char{};
  };
  co_await on<char>(files_, finish_writing);
  co_await crew_.ended();
  hub_.close();
}

// ---- time ----

boost::asio::awaitable<void> CoordinatorImpl::keep_time() {
  while (!stopping_) {
    Instant due = std::max(next_deadline().value_or(Instant::max()), now() + tick_least);
    // A deadline far ahead would hide that this process stood still for most of the way to it.
    if (!workers_.empty()) due = std::min(due, now() + pulse);
    armed_ = due;
    clock_.expires_at(due);
    co_await clock_.async_wait(boost::asio::as_tuple(boost::asio::use_awaitable));
    if (stopping_) co_return;
    if (const Duration late = now() - due; late > stood_still) excuse_workers(late);
    tick();
  }
}

void CoordinatorImpl::excuse_workers(Duration late) {
  log::warn("the coordinator stood still for {:.1f} s", seconds(late));
  for (const auto& [id, worker] : workers_) scheduler_.excuse_worker(id, now());
}

void CoordinatorImpl::results_refused(const std::string& reason) {
  if (!reason.empty()) {
    ++counters_.store_errors;
  } else {
    log::info("results can be kept again");
  }
  refused_ = reason;
  for (const auto& [id, job] : jobs_)
    if (!job.ended) tell_job(id);
}

std::optional<Instant> CoordinatorImpl::next_deadline() const {
  std::optional<Instant> earliest;
  for (const auto& deadline :
       {scheduler_.next_deadline(), frame_news_.next_deadline(), job_news_.next_deadline()})
    if (deadline && (!earliest || *deadline < *earliest)) earliest = deadline;
  if (holding_) earliest = std::min(earliest.value_or(Instant::max()), now() + held_step);
  return earliest;
}

void CoordinatorImpl::wake_in_time() {
  const auto deadline = next_deadline();
  if (!deadline || *deadline >= armed_) return;
  armed_ = Instant::min();  // the clock is about to set it anew
  clock_.cancel();
}

void CoordinatorImpl::tick() {
  perform(scheduler_.tick(now()));
  tell_frames(frame_news_.due(now()));
  for (const auto& [id, unused] : job_news_.due(now()))
    if (const Job* job = find(id)) hub_.publish("job", id, job_event(status_of(*job)));
  hold_or_release();
}

// ---- jobs ----

Job* CoordinatorImpl::find(JobId id) {
  const auto found = jobs_.find(id);
  return found == jobs_.end() ? nullptr : &found->second;
}

const Job* CoordinatorImpl::find(JobId id) const {
  const auto found = jobs_.find(id);
  return found == jobs_.end() ? nullptr : &found->second;
}

Job& CoordinatorImpl::known(JobId id) {
  if (Job* job = find(id)) return *job;
  throw Error(ErrorKind::not_found, fmt::format("there is no job {}", id));
}

JobStatus CoordinatorImpl::status_of(const Job& job) const {
  JobStatus status = job.status(scheduler_.job(job.record.id, now()), now());
  const std::string& trouble = refused_.empty() ? job.trouble : refused_;
  if ((!job.ended || job.owed) && !trouble.empty())
    status.view.waiting_for = "the disk: " + trouble;
  return status;
}

void CoordinatorImpl::tell_frames(const std::vector<FrameThrottle::Frame>& frames) {
  for (const auto& [id, frame] : frames)
    if (const auto newest = version(id, frame))
      hub_.publish("frame", id, frame_event(id, frame, *newest));
}

void CoordinatorImpl::tell_job(JobId id) {
  job_news_.changed(id, 0, now());
  wake_in_time();
}

}  // namespace tessera::server
