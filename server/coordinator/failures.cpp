#include <fmt/format.h>

#include <utility>

#include "common/base/log.hpp"
#include "common/base/names.hpp"
#include "server/coordinator/impl.hpp"

/// Attempts that gave no result: kept for people, the newest of each job.
namespace tessera::server {

namespace {

constexpr std::size_t reason_most = 2000;

Instant now() { return std::chrono::steady_clock::now(); }

const char* word_for(AttemptFailed::Outcome outcome) {
  switch (outcome) {
    case AttemptFailed::Outcome::lost:
      return "lost";
    case AttemptFailed::Outcome::stalled:
      return "stalled";
    case AttemptFailed::Outcome::failed:
      return "failed";
    case AttemptFailed::Outcome::invalid:
      break;
  }
  return "invalid";
}

}  // namespace

void CoordinatorImpl::perform_one(const AttemptFailed& failed) { note_failure(failed, {}); }

void CoordinatorImpl::note_failure(const AttemptFailed& failed, const std::string& log) {
  Job* job = find(failed.job);
  if (!job) return;
  FailureRecord record;
  record.task = failed.task;
  record.lease = failed.lease;
  record.worker = failed.worker;
  record.worker_name = failed.worker_name;
  record.outcome = word_for(failed.outcome);
  record.ended = unix_millis_now();
  if (failed.granted)
    record.started =
        record.ended -
        std::chrono::duration_cast<std::chrono::milliseconds>(now() - *failed.granted).count();
  record.reason = excerpt(failed.reason, reason_most);
  record.log = log;
  log::warn("job {}: {} by worker {} ({}): {}: {}", failed.job,
            failed.task ? text_of(*failed.task) : "its preparation", failed.worker,
            failed.worker_name, record.outcome, excerpt(failed.reason, 400));
  ++job->failures;
  new_failures_[failed.job].push_back(std::move(record));
  tell_job(failed.job);
  if (stopping_ || std::exchange(keeping_failures_, true)) return;
  crew_.start("failed attempts", keep_failures());
}

boost::asio::awaitable<void> CoordinatorImpl::keep_failures() {
  while (!new_failures_.empty()) {
    const auto kept = std::exchange(new_failures_, {});
    const std::function<void()> keep = [this, &kept] {
      for (const auto& [job, failures] : kept) store_->add_failures(job, failures);
    };
    try {
      co_await on_writer(keep);
    } catch (const std::exception& error) {
      log::warn("failed attempts of {} jobs could not be kept: {}", kept.size(), error.what());
    }
  }
  keeping_failures_ = false;
}

boost::asio::awaitable<std::vector<FailureRecord>> CoordinatorImpl::failures(JobId id) {
  known(id);
  // Behind what is being written.
  const std::function<std::vector<FailureRecord>()> read = [this, id] {
    return store_->failures(id);
  };
  co_return co_await on_writer<std::vector<FailureRecord>>(read);
}

}  // namespace tessera::server
