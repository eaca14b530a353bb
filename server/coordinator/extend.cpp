#include <fmt/format.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "server/coordinator/frame_file.hpp"
#include "server/coordinator/impl.hpp"
#include "server/coordinator/job_content.hpp"
#include "server/coordinator/retry.hpp"
#include "server/store/damaged.hpp"

/// More samples for a job that is under way or done.
namespace tessera::server {

namespace {

Instant now() { return std::chrono::steady_clock::now(); }

constexpr Duration look = std::chrono::milliseconds(10);

/// The record as it is to go on with more samples.
JobRecord extended(const Job& job, std::int64_t samples) {
  JobRecord record = job.record;
  record.extended_from.push_back(record.spec.render.samples);
  record.spec.render.samples = samples;
  // Who names the samples wants them all.
  record.spec.time_limit_seconds = record.spec.noise_threshold = 0;
  record.shortened_frames.clear();
  if (!is_end(record.state)) return record;
  record.state = "queued";
  record.started = record.finished = 0;  // its render time so far stays, and counts
  return record;
}

}  // namespace

void CoordinatorImpl::check_extension(const Job& job, std::int64_t samples) const {
  const JobId id = job.record.id;
  if (job.extending || job.removing)
    throw Error(ErrorKind::conflict,
                fmt::format("job {} is just being {}", id, job.removing ? "removed" : "extended"));
  check_it_goes_on(job);
  if (const auto damage = store_->damage().find(id); damage != store_->damage().end())
    throw Error(ErrorKind::conflict,
                fmt::format("job {} cannot be extended: {}. Its pictures stand; put the file back "
                            "and start the server again, or submit the scene with {} samples",
                            id, damage->second, samples));
  // Frames that ended by their noise may have fewer than others: none may lose any.
  const auto [fewest, most] = samples_of_frames(job);
  if (samples < most || samples <= fewest)
    throw Error(ErrorKind::bad_input,
                fmt::format("expected {} than the {} that job {} has or is to have, found {}",
                            fewest < most ? "no fewer samples" : "more samples", most, id, samples),
                {.key = "samples"});
  JobSpec spec = job.plan->spec;
  spec.render.samples = samples;
  check(spec);
}

boost::asio::awaitable<void> CoordinatorImpl::extend(JobId id, std::int64_t samples) {
  check_extension(known(id), samples);
  if (!refused_.empty())
    throw Error(ErrorKind::unreachable,
                fmt::format("the disk refuses what is to be kept, and takes no more samples before "
                            "it takes that: {}",
                            refused_));
  known(id).extending = true;
  const auto outcome = std::make_shared<Extension>();
  crew_.start("an extension", run_extension(id, samples, outcome));
  const Instant most = now() + settings_.patience;
  while (!outcome->over && !stopping_) {
    const Job& job = known(id);
    const std::string& trouble = refused_.empty() ? job.trouble : refused_;
    if (now() > most && outcome->step == Extension::Step::reading)
      throw Error(ErrorKind::unreachable,
                  fmt::format("job {} goes on to {} samples once what it has is read through, "
                              "which takes a while",
                              id, samples));
    if (now() > most && outcome->step == Extension::Step::changing && !trouble.empty())
      throw Error(
          ErrorKind::unreachable,
          fmt::format("job {} goes on to {} samples as soon as the disk takes what is to be "
                      "kept, which it refuses: {}",
                      id, samples, trouble));
    co_await crew_.pause(look);
  }
  if (!outcome->over) throw Error(ErrorKind::unreachable, "the coordinator stops");
  if (outcome->error) std::rethrow_exception(outcome->error);
}

boost::asio::awaitable<void> CoordinatorImpl::run_extension(JobId id, std::int64_t samples,
                                                            std::shared_ptr<Extension> outcome) {
  // Nothing new is begun meanwhile; no task that is out is lost by that.
  perform(scheduler_.pause_job(id, now()));
  try {
    co_await until_extendable(id, outcome);
    outcome->step = Extension::Step::changing;
    co_await extend_checked(id, samples);
  } catch (const std::exception& error) {
    outcome->error = std::current_exception();
    log::warn("job {} is not extended: {}", id, error.what());
  }
  // A coordinator that stops leaves it so: the scheduler's word on the job is not its state.
  if (!stopping_) {
    Job& job = known(id);
    job.extending = false;
    if (job.record.state != "paused") perform(scheduler_.resume_job(id, now()));
  }
  outcome->over = true;
  files_changed_.notify();
}

bool CoordinatorImpl::is_busy(JobId id) const {
  const Job& job = *find(id);
  return job.arriving > 0 || job.at_work > 0 || (job.ending && !job.ended && !job.broken);
}

boost::asio::awaitable<void> CoordinatorImpl::until_quiet(JobId id) {
  const Instant most = now() + settings_.patience;
  while (is_busy(id)) {
    if (stopping_) throw Error(ErrorKind::unreachable, "the coordinator stops");
    const std::string& trouble = refused_.empty() ? known(id).trouble : refused_;
    if (now() > most)
      throw Error(ErrorKind::unreachable,
                  fmt::format("job {} is as it was: what it has is still being written{}{}; try "
                              "again later",
                              id, trouble.empty() ? "" : ", and the disk refuses it: ", trouble));
    co_await crew_.pause(look);
  }
}

boost::asio::awaitable<void> CoordinatorImpl::until_extendable(JobId id,
                                                               std::shared_ptr<Extension> outcome) {
  co_await until_quiet(id);
  check_it_goes_on(known(id));
  outcome->step = Extension::Step::reading;
  // What it is to go on from is on disk alone from here on: it has to be there.
  const std::function<char()> check = [this, id] {
    check_readable(*store_, read_job(*store_, id), [this] { return stopped_.load(); });
    return char{};
  };
  try {
    co_await on<char>(checkpoints_, check);
  } catch (const DamagedError& error) {
    throw Error(ErrorKind::conflict,
                fmt::format("job {} cannot be extended: {}", id, error.what()));
  }
  // Of what was out something may have come.
  co_await until_quiet(id);
  check_it_goes_on(known(id));
}

void CoordinatorImpl::check_it_goes_on(const Job& job) const {
  const JobId id = job.record.id;
  if (job.broken)
    throw Error(ErrorKind::conflict,
                fmt::format("job {} cannot be extended, for what it has could not be read back: {}",
                            id, job.unreadable));
  const std::string state = job.ended ? job.record.state : status_of(job).view.state;
  if (state == "failed" || state == "cancelled")
    throw Error(ErrorKind::conflict,
                fmt::format("job {} has {}: only one that is done or under way can be extended", id,
                            state == "cancelled" ? "been cancelled" : "failed"));
}

boost::asio::awaitable<void> CoordinatorImpl::extend_checked(JobId id, std::int64_t samples) {
  // Nothing of the old plan must reach the store after the new one.
  perform(scheduler_.cancel_job(id, now()));
  const Job& job = known(id);
  JobRecord record = job.record;
  std::exception_ptr error;
  // Where frames that ended by their noise go on to what was asked for the plan stays as it is.
  const PassPlan& plan = job.plan->passes;
  const std::uint32_t kept = samples == plan.samples() ? plan.count() : plan.regular();
  const std::function<JobRecord()> change = [this, record = extended(job, samples), kept] {
    store_->extend_job(record, kept);
    return record;
  };
  try {
    record = co_await on_writer<JobRecord>(change);
  } catch (const std::exception&) {
    error = std::current_exception();
  }
  if (error && job.ended) std::rethrow_exception(error);  // it stays as it is
  co_await reopen(std::move(record));
  if (error) std::rethrow_exception(error);
  log::info("job {} goes on to {} samples", id, samples);
}

boost::asio::awaitable<JobContent> CoordinatorImpl::read_surely(JobId id) {
  const std::function<JobContent()> read = [this, id] { return read_job(*store_, id); };
  for (Duration wait = retry_first;; wait = longer(wait)) {
    try {
      co_return co_await on<JobContent>(checkpoints_, read);
    } catch (const std::exception& error) {
      if (crew_.stopping()) throw;
      log::error("job {}: what is kept of it could not be read: {}", id, error.what());
      known(id).trouble = error.what();
    }
    tell_job(id);
    co_await crew_.pause(wait);
  }
}

boost::asio::awaitable<void> CoordinatorImpl::reopen(JobRecord record) {
  const JobId id = record.id;
  const JobContent content = co_await read_surely(id);
  tell_frames(frame_news_.forget(id));
  films_.forget(id);
  pictures_.forget(id);
  Job& job = known(id);
  std::set<std::int32_t> files = job.files;
  const std::uint64_t failures = job.failures;
  const int arriving = job.arriving;
  const int at_work = job.at_work;
  // Pictures of the plan before are none any more, but for those with as many samples.
  if (record.extended_from != job.record.extended_from)
    std::erase_if(files, [&](std::int32_t frame) {
      return job.samples_of(frame) != record.spec.render.samples;
    });
  job = Job(record, now(), unix_millis_now());
  job.extending = true;
  job.failures = failures;
  job.arriving = arriving;
  job.at_work = at_work;
  job.files = files;
  for (auto& [worker, entry] : workers_) entry.told.erase(id);
  perform(scheduler_.replace_job(id, job.plan, now(), job.earlier_plans));
  take_in(job, content);
  if (job.record.state != "paused") perform(scheduler_.resume_job(id, now()));
  tell_job(id);
}

}  // namespace tessera::server
