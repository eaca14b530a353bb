#include <algorithm>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "server/coordinator/frame_file.hpp"
#include "server/coordinator/impl.hpp"
#include "server/coordinator/job_content.hpp"

/// The pictures of jobs that failed or were cancelled. What a failed job had stays until they are
/// written; what a cancelled one had goes after one try.
namespace tessera::server {

namespace {

Instant now() { return std::chrono::steady_clock::now(); }

constexpr Duration owed_retry_most = std::chrono::minutes(5);

}  // namespace

boost::asio::awaitable<void> CoordinatorImpl::keep_owed_pictures() {
  while (!crew_.stopping()) {
    std::vector<JobId> due;
    for (const auto& [id, job] : jobs_)
      if (job.owed && job.owed->next <= now() && job.at_rest()) due.push_back(id);
    // One after another: each takes a film's memory.
    for (const JobId id : due) {
      const Job* job = find(id);
      if (job && job->owed && job->at_rest() && !crew_.stopping()) co_await write_owed(id);
    }
    co_await crew_.pause(settings_.upkeep);
  }
}

boost::asio::awaitable<void> CoordinatorImpl::write_owed(JobId id) {
  const AtWork working = at_work(id);
  Job& job = known(id);
  const std::function<JobContent()> read = [this, id] { return read_job(*store_, id); };
  bool kept = false;
  try {
    const JobContent content = co_await on<JobContent>(checkpoints_, read);
    restore_films(job, content, !job.record.extended_from.empty());
    kept = co_await keep_pictures(id);
  } catch (const std::exception& error) {
    log::error("job {}: its pictures could not be written: {}", id, error.what());
    job.trouble = error.what();
  }
  let_go(id);
  co_await settle_what_is_owed(id, kept);
}

boost::asio::awaitable<void> CoordinatorImpl::settle_what_is_owed(JobId id, bool kept) {
  if (crew_.stopping() && !kept) co_return;  // the next start goes on
  Job& job = known(id);
  if (!kept && job.record.state == "failed") {
    job.owed->wait = std::min(std::max(2 * job.owed->wait, settings_.upkeep), owed_retry_most);
    job.owed->next = now() + job.owed->wait;
    log::warn("job {}: not all its pictures are written; its results stay till then", id);
    co_return;
  }
  if (!kept) log::warn("job {}: not all its pictures are written; its results go", id);
  job.owed.reset();
  job.trouble.clear();
  co_await forget_results(id);
}

boost::asio::awaitable<void> CoordinatorImpl::forget_results(JobId id) {
  return drop_results(id, &Store::end_job);
}

boost::asio::awaitable<void> CoordinatorImpl::drop_results(JobId id, void (Store::*drop)(JobId)) {
  const std::function<void()> work = [this, id, drop] { ((*store_).*drop)(id); };
  try {
    co_await on_writer(work);
  } catch (const std::exception& error) {
    log::warn(
        "job {}: its results could not be removed from the journal: {}; the next start tries "
        "again",
        id, error.what());
  }
}

}  // namespace tessera::server
