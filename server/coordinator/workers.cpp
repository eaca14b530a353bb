#include <fmt/format.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/base/names.hpp"
#include "server/coordinator/impl.hpp"

/// What workers say, and what becomes of their results.
namespace tessera::server {

namespace {

Instant now() { return std::chrono::steady_clock::now(); }

/// No task traces as many: its paths' vertices, each with its light samples, four times over.
double rays_most(std::int64_t samples, const RenderSettings& render) {
  return 4.0 * static_cast<double>(samples) * (render.bounces + 2) * (render.light_samples + 1);
}

/// What a result says of itself must fit its task; empty if it does.
std::string fault_of(const wire::Result& result, const image::TileExpectation& expected,
                     const RenderSettings& render) {
  const std::int64_t samples = expected.window.pixels() * expected.samples;
  if (result.samples != samples)
    return fmt::format("samples: expected {} for {}, found {}", samples, text_of(result.task),
                       result.samples);
  if (result.rejected < 0 || result.rejected > samples)
    return fmt::format("rejected: expected 0 to {}, found {}", samples, result.rejected);
  const double most = rays_most(samples, render);
  if (result.rays < 0 || static_cast<double>(result.rays) > most)
    return fmt::format("rays: expected 0 to {:.0f}, found {}", most, result.rays);
  if (!(result.seconds >= 0 && result.seconds < 1e9))
    return "seconds: expected a number from 0 to 1e9";
  return {};
}

}  // namespace

std::vector<WorkerView> CoordinatorImpl::workers() const { return scheduler_.workers(now()); }

std::string CoordinatorImpl::refuse(const wire::Result& result, const Job* job) {
  if (job && job->plan->digest != result.plan) {
    ++counters_.rejected.plan;
    return "the result is of another plan than the job's";
  }
  if (job && !job->plan->contains(result.task)) {
    ++counters_.rejected.task;
    return fmt::format("the job has no {}", text_of(result.task));
  }
  ++counters_.rejected.lease;
  return fmt::format("lease {}.{} was not granted to this worker for {}", result.lease.epoch,
                     result.lease.number, text_of(result.task));
}

WorkerId CoordinatorImpl::worker_joined(const WorkerInfo& info, std::shared_ptr<WorkerLink> link) {
  const Scheduler::Joined joined = scheduler_.worker_joined(info, now());
  ++counters_.workers_joined;
  workers_[joined.worker] = {info, link, {}};
  if (holding_) link->hold(true);
  perform(joined.actions);
  hub_.publish("worker", 0, worker_event(joined.worker, info.name, "joined"));
  return joined.worker;
}

void CoordinatorImpl::worker_heard(WorkerId worker) { scheduler_.worker_heard(worker, now()); }

void CoordinatorImpl::excuse_worker(WorkerId worker) { scheduler_.excuse_worker(worker, now()); }

namespace {
/// What one worker says of its cache, or nothing when it leaves, in what is counted of all.
void count(CoordinatorCounters& all, std::optional<wire::CacheUse>& known,
           const std::optional<wire::CacheUse>& now) {
  const wire::CacheUse before = known.value_or(wire::CacheUse()),
                       after = now.value_or(wire::CacheUse());
  all.worker_cache_bytes += after.bytes - before.bytes;
  all.worker_cache_most += after.most - before.most;
  if (known && now && after.evictions > before.evictions)
    all.worker_cache_evictions += after.evictions - before.evictions;
  known = now;
}
}  // namespace

void CoordinatorImpl::worker_left(WorkerId worker, bool clean) {
  const auto found = workers_.find(worker);
  if (found == workers_.end()) return;
  count(counters_, found->second.cache, std::nullopt);
  const std::string name = found->second.info.name;
  workers_.erase(found);
  if (!clean) ++counters_.workers_lost;
  perform(scheduler_.worker_left(worker, clean, now()));
  log::info("worker {} ({}) has left{}", worker, name, clean ? "" : " without a word");
  hub_.publish("worker", 0, worker_event(worker, name, "left"));
}

void CoordinatorImpl::drain_worker(WorkerId worker) {
  const auto found = workers_.find(worker);
  if (found == workers_.end())
    throw Error(ErrorKind::not_found, fmt::format("there is no worker {}", worker));
  perform(scheduler_.drain_worker(worker, now()));
  send(worker, wire::Drain{"asked for by a person"});
  hub_.publish("worker", 0, worker_event(worker, found->second.info.name, "draining"));
}

void CoordinatorImpl::worker_said(WorkerId worker, wire::Message message) {
  if (!workers_.contains(worker)) return;
  if (const auto* preparing = std::get_if<wire::Preparing>(&message)) {
    perform(scheduler_.worker_preparing(worker, preparing->job, preparing->fraction, now()));
  } else if (const auto* ready = std::get_if<wire::Ready>(&message)) {
    perform(scheduler_.worker_ready(worker, ready->job, now()));
  } else if (const auto* progress = std::get_if<wire::Progress>(&message)) {
    std::vector<std::pair<LeaseId, double>> running;
    running.reserve(progress->running.size());
    for (const auto& one : progress->running) running.emplace_back(one.lease, one.fraction);
    if (progress->cache) count(counters_, workers_.at(worker).cache, progress->cache);
    perform(scheduler_.worker_progress(worker, running, now()));
  } else if (const auto* failed = std::get_if<wire::Failed>(&message)) {
    Actions actions =
        failed->code == "files"
            ? scheduler_.worker_lacks_files(worker, failed->job, failed->reason, now())
            : scheduler_.worker_failed(worker, failed->job, failed->lease, failed->reason, now());
    // The worker's own log goes with what it said, which is the first of these.
    const auto said = std::find_if(actions.begin(), actions.end(), [](const Action& action) {
      return std::holds_alternative<AttemptFailed>(action);
    });
    if (said != actions.end()) {
      note_failure(std::get<AttemptFailed>(*said), failed->log);
      actions.erase(said);
    }
    perform(actions);
  } else if (std::holds_alternative<wire::Drain>(message)) {
    perform(scheduler_.drain_worker(worker, now()));
    hub_.publish("worker", 0, worker_event(worker, workers_[worker].info.name, "draining"));
  }
}

void CoordinatorImpl::worker_result(WorkerId worker, wire::Result result,
                                    std::vector<std::byte> exr) {
  const auto found = workers_.find(worker);
  if (found == workers_.end() || stopping_) return;
  Job* job = find(result.job);
  const Verdict verdict =
      scheduler_.result_arrived(worker, result.lease, result.job, result.plan, result.task, now());
  if (verdict == Verdict::stale || (verdict == Verdict::take && !job)) {
    ++(job && !job->ending && !job->ended ? counters_.results_duplicate : counters_.results_stale);
    send(worker, wire::Stale{result.lease});
  } else if (verdict == Verdict::rejected) {
    const std::string reason = refuse(result, job);
    log::warn("worker {} ({}): a result is rejected: {}", worker, found->second.info.name, reason);
    send(worker, wire::Rejected{result.lease, reason});
  } else {
    ArrivedResult arrived;
    arrived.worker = worker;
    arrived.info = {
        result.job,     result.plan, result.task,     result.lease,   found->second.info.identity,
        result.samples, result.rays, result.rejected, result.seconds, result.cpu_seconds};
    arrived.worker_name = found->second.info.name;
    arrived.worker_build = found->second.info.build_id;
    const image::TileExpectation expected = expectation_of(*job->plan, result.task);
    if (const std::string fault = fault_of(result, expected, job->plan->spec.render);
        !fault.empty()) {
      ++counters_.rejected.statistics;
      result_invalid(arrived, fault);
    } else {
      ++job->arriving;
      arrived.budget = in_flight_.take(exr.size());
      arrived.exr = std::make_shared<const std::vector<std::byte>>(std::move(exr));
      results_.arrived(std::move(arrived), expected);
    }
  }
  hold_or_release();
  wake_in_time();
}

void CoordinatorImpl::result_invalid(const ArrivedResult& result, const std::string& reason) {
  log::warn("worker {} ({}): {} of job {} is not taken: {}", result.worker, result.worker_name,
            text_of(result.info.task), result.info.job, reason);
  send(result.worker, wire::Rejected{result.info.lease, reason});
  perform(scheduler_.result_invalid(result.worker, result.info.lease, result.info.job,
                                    result.info.task, reason, now()));
  hold_or_release();
}

void CoordinatorImpl::end_arriving(Job& job) {
  if (--job.arriving == 0 && job.extending) files_changed_.notify();
}

void CoordinatorImpl::forget_late_results(JobId id) {
  const Job* job = find(id);
  if (stopping_ || !job) return;
  const bool done = job->record.state == "done";
  if (!done && job->owed) return;  // they go with all that it had
  crew_.start("late results of an ended job", done ? forget_settled(id) : forget_results(id));
}

void CoordinatorImpl::results_durable(std::vector<ArrivedResult> results) {
  std::set<JobId> late;
  for (ArrivedResult& result : results) {
    const ResultInfo& info = result.info;
    ++counters_.results_accepted;
    send(result.worker, wire::Accepted{info.lease});
    perform(scheduler_.result_durable(result.worker, info.lease, info.job, info.task, info.samples,
                                      info.seconds, now()));
    Job* job = find(info.job);
    if (job) end_arriving(*job);
    if (!job || job->ended) {
      late.insert(info.job);
      continue;
    }
    job->count(result.worker_name, info.samples, info.rays, info.rejected, info.cpu_seconds,
               result.worker_build);
    films_.durable(info.job, job->plan, job->version_base, info.task, result.place,
                   std::move(result.decoded));
  }
  results.clear();
  // They were being decoded when their job ended, and were appended after its own were removed.
  for (const JobId id : late) forget_late_results(id);
  films_.flush();
  hold_or_release();
}

void CoordinatorImpl::send(WorkerId worker, wire::Message message) {
  const auto found = workers_.find(worker);
  if (found != workers_.end()) found->second.link->send(std::move(message));
}

void CoordinatorImpl::hold_or_release() {
  // Released at half, so that it does not flutter. What a session has begun to read still comes in.
  const bool hold = in_flight_.used() > (holding_ ? settings_.in_flight / 2 : settings_.in_flight);
  if (hold == holding_) return;
  holding_ = hold;
  log::debug("{} bytes of results in flight: workers are {}", in_flight_.used(),
             hold ? "held" : "read again");
  for (const auto& [id, worker] : workers_) worker.link->hold(hold);
  wake_in_time();
}

}  // namespace tessera::server
