// Failed attempts in the database.
#include <algorithm>

#include "server/store/index.hpp"

namespace tessera::server {

void Index::add_failures(JobId job, std::span<const FailureRecord> failures, std::size_t kept) {
  Transaction transaction(writer_);
  Statement last = writer_.prepare("SELECT coalesce(max(number), 0) FROM failures WHERE job = ?1");
  last.run(job);
  std::int64_t number = last.integer(0);
  last.reset();
  Statement add = writer_.prepare(
      "INSERT INTO failures VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14)");
  for (const FailureRecord& failure : failures) {
    ++number;
    const TaskId task = failure.task.value_or(TaskId{});
    const std::int64_t pass = failure.task ? std::int64_t{task.pass} : -1;
    add.run(job, number, task.frame, task.tile, pass, failure.lease.epoch, failure.lease.number,
            failure.worker, failure.worker_name, failure.outcome, failure.started, failure.ended,
            failure.reason, failure.log);
  }
  writer_.prepare("DELETE FROM failures WHERE job = ?1 AND number <= ?2")
      .run(job, number - static_cast<std::int64_t>(kept));
  transaction.commit();
}

std::vector<FailureRecord> Index::failures(JobId job) const {
  const std::lock_guard lock(reading_);
  std::vector<FailureRecord> found;
  Statement rows = reader_->prepare(
      "SELECT number, frame, tile, pass, epoch, lease, worker, worker_name, outcome, started, "
      "ended, reason, log FROM failures WHERE job = ?1 ORDER BY number DESC");
  for (bool more = rows.run(job); more; more = rows.step()) {
    int column = 0;
    FailureRecord failure;
    failure.number = static_cast<std::uint64_t>(rows.integer(column++));
    const auto frame = static_cast<std::int32_t>(rows.integer(column++));
    const auto tile = static_cast<std::uint32_t>(rows.integer(column++));
    const std::int64_t pass = rows.integer(column++);
    if (pass >= 0) failure.task = TaskId{frame, tile, static_cast<std::uint32_t>(pass)};
    failure.lease.epoch = static_cast<std::uint64_t>(rows.integer(column++));
    failure.lease.number = static_cast<std::uint64_t>(rows.integer(column++));
    failure.worker = static_cast<std::uint64_t>(rows.integer(column++));
    failure.worker_name = rows.text(column++);
    failure.outcome = rows.text(column++);
    failure.started = rows.integer(column++);
    failure.ended = rows.integer(column++);
    failure.reason = rows.text(column++);
    failure.log = rows.text(column++);
    found.push_back(std::move(failure));
  }
  return found;
}

std::map<JobId, std::uint64_t> Index::failure_counts() const {
  const std::lock_guard lock(reading_);
  std::map<JobId, std::uint64_t> counts;
  Statement rows = reader_->prepare("SELECT job, max(number) FROM failures GROUP BY job");
  for (bool more = rows.run(); more; more = rows.step())
    counts[static_cast<JobId>(rows.integer(0))] = static_cast<std::uint64_t>(rows.integer(1));
  return counts;
}

}  // namespace tessera::server
