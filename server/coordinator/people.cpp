#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/assets/bundle.hpp"
#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/log.hpp"
#include "server/coordinator/impl.hpp"
#include "server/film/film_tile_bytes.hpp"

/// What people ask of the coordinator.
namespace tessera::server {

namespace {

constexpr Duration repeated_wait = std::chrono::milliseconds(20);

Instant now() { return std::chrono::steady_clock::now(); }

using Pins = std::vector<std::shared_ptr<assets::BlobStore::Pin>>;

/// Throws Error{conflict} unless the bundle and every blob that it names are here. They stay while
/// the pins live. Blocks.
Pins check_assets(assets::BlobStore& blobs, const Digest& bundle) {
  Pins pins{blobs.pin({bundle})};
  if (!blobs.has(bundle))
    throw Error(ErrorKind::conflict,
                fmt::format("the bundle {} is not here: upload it first", bundle.hex()),
                {.key = "bundle"});
  const assets::Bundle files = assets::bundle_from_json(
      blobs.read(bundle, limits::bundle_json_bytes), "bundle " + bundle.hex());
  const std::vector<Digest> named = assets::blobs_of(files);
  pins.push_back(blobs.pin(named));
  const std::vector<Digest> missing = blobs.missing(named);
  if (missing.empty()) return pins;
  const auto lacking = std::find_if(files.files.begin(), files.files.end(), [&](const auto& entry) {
    return entry.second.digest == missing.front();
  });
  throw Error(
      ErrorKind::conflict,
      fmt::format(
          "{} of the bundle's {} blobs are not here: upload them first; one of them is {} ({})",
          missing.size(), named.size(), missing.front().hex(), lacking->first),
      {.key = "bundle"});
}

/// Throws Error{too_large} if the film of one frame is more than all films may take.
void check_film(const JobSpec& spec, std::uint64_t most) {
  const Rect window = spec.render.window();
  const std::size_t film = film_bytes(window.pixels(), *image::layout_of(spec.render.aovs));
  if (film > most)
    throw Error(
        ErrorKind::too_large,
        fmt::format("the film of a frame of {} by {} takes {} bytes of memory, and all films "
                    "may take {} (tessera-server --film-memory)",
                    window.width, window.height, film, most),
        {.key = "render.width"});
}

/// Throws Error{bad_input} that names the key.
void check_change(const JobChange& change, const RenderSettings& film) {
  const auto within = [](const char* key, std::int64_t value, std::int64_t low, std::int64_t high) {
    if (value >= low && value <= high) return;
    throw Error(ErrorKind::bad_input,
                fmt::format("expected a whole number from {} to {}, found {}", low, high, value),
                {.key = key});
  };
  if (change.priority)
    within("priority", *change.priority, -limits::priority_max, limits::priority_max);
  if (change.max_workers) within("max_workers", *change.max_workers, 0, limits::job_workers_max);
  if (change.focus && *change.focus) check_focus(**change.focus, film);
}

/// Gives what stood there before, as a change that takes it back.
JobChange exchanged(JobRecord& record, const JobChange& change) {
  JobChange before;
  if (change.priority) before.priority = std::exchange(record.priority, *change.priority);
  if (change.max_workers)
    before.max_workers = std::exchange(record.spec.max_workers, *change.max_workers);
  if (change.focus) before.focus = std::exchange(record.spec.focus, *change.focus);
  return before;
}

}  // namespace

boost::asio::awaitable<JobId> CoordinatorImpl::submit(JobSpec spec) {
  check(spec);
  JobRecord record;
  record.spec = std::move(spec);
  co_return co_await put_job(std::move(record));
}

boost::asio::awaitable<Submitted> CoordinatorImpl::submit_once(JobSpec spec,
                                                               std::string idempotency_key) {
  check(spec);
  JobRecord record;
  record.idempotency_key = idempotency_key;
  record.idempotency_fingerprint = digest_of(to_json(spec).dump()).hex();
  record.spec = std::move(spec);
  Submitted submitted;
  for (;;) {
    const auto earlier = requests_.find(idempotency_key);
    if (earlier == requests_.end()) break;
    submitted.job = earlier->second.job;
    submitted.of_another_request = earlier->second.fingerprint != record.idempotency_fingerprint;
    if (submitted.job != 0) co_return submitted;
    co_await crew_.pause(repeated_wait);  // it came while the first is being kept
    if (stopping_) throw Error(ErrorKind::unreachable, "the coordinator stops");
  }
  requests_[idempotency_key] = {0, record.idempotency_fingerprint};
  try {
    submitted.job = co_await put_job(std::move(record));
  } catch (...) {
    requests_.erase(idempotency_key);
    throw;
  }
  submitted.of_another_request = false;
  requests_[idempotency_key].job = submitted.job;
  co_return submitted;
}

boost::asio::awaitable<JobId> CoordinatorImpl::put_job(JobRecord record) {
  if (const std::string reason = lacks_room(0); !reason.empty())
    throw Error(ErrorKind::no_room, reason);
  check_film(record.spec, settings_.film_memory);
  const std::function<Pins()> look = [this, bundle = record.spec.bundle] {
    return check_assets(blobs_, bundle);
  };
  auto pinned = std::make_shared<Pins>(co_await on<Pins>(files_, look));
  record.priority = record.spec.priority;
  record.created = unix_millis_now();
  const std::function<JobId()> put = [this, record] { return store_->put_job(record); };
  std::exception_ptr error;
  try {
    record.id = co_await on_writer<JobId>(put);
  } catch (const std::exception&) {
    error = std::current_exception();
  }
  // Giving them up waits for whoever collects blobs.
  boost::asio::post(files_, [pins = std::move(pinned)]() mutable { pins.reset(); });
  if (error) std::rethrow_exception(error);
  const Job& job = jobs_.try_emplace(record.id, record, now(), unix_millis_now()).first->second;
  log::info("job {} ({}): {} tasks, plan {}", record.id, record.spec.name, job.plan->tasks(),
            job.plan->digest.hex().substr(0, 12));
  for (const std::string& matte :
       mattes_without_names(record.spec.render.aovs, record.spec.cryptomatte))
    log::warn("job {}: {} was sent no names, and comes without a manifest", record.id, matte);
  perform(scheduler_.add_job(record.id, job.plan, now()));
  tell_job(record.id);
  co_return record.id;
}

std::vector<JobStatus> CoordinatorImpl::jobs() const {
  std::vector<JobStatus> all;
  all.reserve(jobs_.size());
  for (const auto& [id, job] : jobs_) all.push_back(status_of(job));
  return all;
}

std::optional<JobStatus> CoordinatorImpl::job(JobId id) const {
  const Job* found = find(id);
  if (!found) return std::nullopt;
  return status_of(*found);
}

Job& CoordinatorImpl::live(JobId id) {
  Job& job = known(id);
  if (job.extending || job.removing)
    throw Error(ErrorKind::conflict,
                fmt::format("job {} is just being {}", id, job.removing ? "removed" : "extended"));
  if (!job.ending && !job.ended) return job;
  const std::string state = status_of(job).view.state;
  throw Error(ErrorKind::conflict,
              is_end(state) ? fmt::format("job {} is {}", id, state)
                            : fmt::format("job {} is rendered, its files are being written", id));
}

boost::asio::awaitable<void> CoordinatorImpl::until_unchanging(JobId id) {
  while (live(id).changing) co_await files_changed_.wait();
}

boost::asio::awaitable<void> CoordinatorImpl::cancel(JobId id) {
  // What cannot be read back is kept until the job is cancelled.
  const Job& known_job = known(id);
  const bool broken =
      known_job.broken && known_job.ending && !known_job.ended && !known_job.extending;
  Job& job = broken ? known(id) : live(id);
  job.ending = true;
  job.broken = false;
  const JobRecord end = job.end_record("cancelled", "", now(), unix_millis_now());
  job.end = end;
  const std::exception_ptr error = co_await save_or_error(id);
  job.end.reset();
  if (error) {
    job.broken = job.broken || broken;
    job.ending = job.broken;
    keep(job);
    // What the scheduler said meanwhile was not heard.
    const auto view = scheduler_.job(id, now());
    if (view && view->state == "done") perform_one(JobFinished{id});
    if (view && view->state == "failed") perform_one(JobFailed{id, view->error});
    std::rethrow_exception(error);
  }
  job.has_ended_as(end);
  job.spec_changed();  // its time may have been up meanwhile
  perform(scheduler_.cancel_job(id, now()));
  log::info("job {} is cancelled", id);
  tell_job(id);
  if (!stopping_) crew_.start("a cancelled job's pictures", abandon_job(id, "cancelled", ""));
}

boost::asio::awaitable<void> CoordinatorImpl::pause(JobId id) {
  co_await until_unchanging(id);
  Job& job = live(id);
  const Changing turn(alive_, job, files_changed_);
  // Changed here first, so that whatever else is kept of the job meanwhile says the same.
  const std::string before = std::exchange(job.record.state, "paused");
  if (const auto error = co_await save_or_error(id)) {
    if (job.record.state == "paused") job.record.state = before;
    keep(job);
    std::rethrow_exception(error);
  }
  perform(scheduler_.pause_job(id, now()));
  tell_job(id);
}

boost::asio::awaitable<void> CoordinatorImpl::resume(JobId id) {
  co_await until_unchanging(id);
  Job& job = live(id);
  if (job.record.state != "paused") co_return;
  const Changing turn(alive_, job, files_changed_);
  const std::string after = job.record.started != 0 ? "rendering" : "queued";
  job.record.state = after;
  if (const auto error = co_await save_or_error(id)) {
    if (job.record.state == after) job.record.state = "paused";
    keep(job);
    std::rethrow_exception(error);
  }
  perform(scheduler_.resume_job(id, now()));
  tell_job(id);
}

boost::asio::awaitable<void> CoordinatorImpl::change(JobId id, JobChange change) {
  co_await until_unchanging(id);
  Job& job = live(id);
  check_change(change, job.record.spec.render);
  const Changing turn(alive_, job, files_changed_);
  // Changed here first, so that whatever else is kept of the job meanwhile says the same.
  const JobChange before = exchanged(job.record, change);
  if (const auto error = co_await save_or_error(id)) {
    exchanged(job.record, before);
    keep(job);
    std::rethrow_exception(error);
  }
  job.spec_changed();
  if (change.priority) perform(scheduler_.set_priority(id, *change.priority, now()));
  if (change.max_workers) perform(scheduler_.set_max_workers(id, *change.max_workers, now()));
  if (change.focus) perform(scheduler_.set_focus(id, *change.focus, now()));
  tell_job(id);
}

boost::asio::awaitable<std::exception_ptr> CoordinatorImpl::save_or_error(JobId id) {
  const std::function<void()> update = [this, record = known(id).to_keep()] {
    store_->update_job(record);
  };
  try {
    co_await on_writer(update);
  } catch (const std::exception&) {
    co_return std::current_exception();
  }
  co_return nullptr;
}

std::unique_ptr<Subscription> CoordinatorImpl::subscribe(std::optional<JobId> job) {
  return hub_.subscribe(job);
}

}  // namespace tessera::server
