#include <fmt/format.h>

#include <utility>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "server/coordinator/frame_file.hpp"
#include "server/coordinator/impl.hpp"
#include "server/coordinator/storage_policy.hpp"

/// Jobs that are forgotten, with all that is theirs: their time is over, or a person says so.
namespace tessera::server {

namespace {

namespace fs = std::filesystem;

constexpr Duration rest_look = std::chrono::milliseconds(20);

Instant now() { return std::chrono::steady_clock::now(); }

/// A job's folder has this name from before the store forgets the job until it is removed.
constexpr std::string_view forgotten = ".forgotten";

fs::path forgotten_folder(const fs::path& data, JobId id) {
  return job_folder(data, id).string() + std::string(forgotten);
}

void set_aside(const fs::path& data, JobId id, bool durable) {
  const fs::path aside = forgotten_folder(data, id);
  std::error_code error;
  if (!fs::exists(job_folder(data, id), error)) return;
  fs::remove_all(aside,
                 error);  // what an attempt before left; the rename says if it is there still
  system_disk()->rename(job_folder(data, id), aside);
  if (durable) system_disk()->sync_folder(aside.parent_path());
}

void take_back(const fs::path& data, JobId id) {
  std::error_code error;
  fs::rename(forgotten_folder(data, id), job_folder(data, id), error);
  if (error && error != std::errc::no_such_file_or_directory)
    log::warn("{} could not get its name back: {}", forgotten_folder(data, id).string(),
              error.message());
}

}  // namespace

boost::asio::awaitable<void> CoordinatorImpl::forget_job(JobId id, std::string why) {
  known(id).removing = true;
  const std::function<void()> forget = [this, id] {
    try {
      set_aside(settings_.data, id, settings_.durable);
      store_->forget_job(id);
    } catch (const std::exception&) {
      take_back(settings_.data, id);
      throw;
    }
  };
  std::exception_ptr error;
  try {
    co_await on_writer(forget);
  } catch (const std::exception&) {
    error = std::current_exception();
  }
  Job& job = known(id);
  if (error) job.removing = false;
  if (error) std::rethrow_exception(error);
  const std::string event = removed_event(job);
  frame_news_.forget(id);
  job_news_.forget(id);
  pictures_.forget(id);
  films_.forget(id);
  new_failures_.erase(id);
  requests_.erase(job.record.idempotency_key);
  jobs_.erase(id);
  collect_soon_ = true;
  hub_.publish("removed", id, event);
  log::info("job {} is forgotten: {}", id, why);
  const std::function<char()> remove = [folder = forgotten_folder(settings_.data, id)] {
    std::error_code ignored;  // the next start removes it
    fs::remove_all(folder, ignored);
    return char{};
  };
  co_await on<char>(upkeep_, remove);
}

boost::asio::awaitable<void> CoordinatorImpl::forget_expired() {
  std::vector<JobId> expired;
  for (const auto& [id, job] : jobs_)
    if (job.at_rest() && has_expired(job.record.finished, unix_millis_now(), settings_.keep_jobs))
      expired.push_back(id);
  for (const JobId id : expired) {
    const Job* job = find(id);
    if (!job || !job->at_rest()) continue;
    try {
      co_await forget_job(id, "it ended longer ago than jobs are kept");
    } catch (const std::exception& error) {
      log::warn("job {} could not be forgotten: {}", id, error.what());  // tried again
    }
  }
}

boost::asio::awaitable<void> CoordinatorImpl::until_at_rest(JobId id) {
  const Instant most = now() + settings_.patience;
  for (;;) {
    const Job& job = known(id);
    if (job.extending || job.removing)
      throw Error(ErrorKind::conflict, fmt::format("job {} is just being {}", id,
                                                   job.removing ? "removed" : "extended"));
    if (!job.ended)
      throw Error(ErrorKind::conflict, fmt::format("job {} has not ended: cancel it first", id));
    if (job.at_rest()) co_return;
    known(id).unwanted = true;
    if (now() > most)
      throw Error(ErrorKind::conflict,
                  fmt::format("what is kept of job {} is still being written{}{}", id,
                              refused_.empty() ? "" : ", and the disk refuses it: ", refused_));
    co_await crew_.pause(rest_look);
    if (stopping_) throw Error(ErrorKind::unreachable, "the coordinator stops");
  }
}

boost::asio::awaitable<void> CoordinatorImpl::purge(JobId id) {
  std::exception_ptr error;
  try {
    co_await until_at_rest(id);
    co_await forget_job(id, "a person has removed it");
  } catch (const std::exception&) {
    error = std::current_exception();
  }
  if (!error) co_return;
  Job* job = find(id);
  if (job && std::exchange(job->unwanted, false) && !stopping_) {
    settle_all(*job);
    if (job->record.state == "done") crew_.start("a done job's results", forget_settled(id));
  }
  std::rethrow_exception(error);
}

void CoordinatorImpl::settle_job_folders(const std::vector<JobRecord>& records) {
  constexpr JobId countable = JobId{1} << 52U;  // above it no job's number ever comes
  std::set<JobId> known;
  for (const JobRecord& record : records) known.insert(record.id);
  std::set<JobId> strangers;
  std::error_code error;
  std::vector<std::string> names;
  for (fs::directory_iterator entry(settings_.data / "jobs", error), end; !error && entry != end;
       entry.increment(error))
    names.push_back(entry->path().filename().string());
  for (const std::string& name : names) {
    const bool aside = name.ends_with(forgotten);
    const auto id = job_id_from(name.substr(0, name.size() - (aside ? forgotten.size() : 0)));
    if (!id) continue;
    std::error_code ignored;  // the next start tries again
    if (aside && known.contains(*id)) {
      take_back(settings_.data, *id);
    } else if (aside) {
      fs::remove_all(settings_.data / "jobs" / name, ignored);
    } else if (!known.contains(*id) && *id < countable) {
      strangers.insert(*id);
    }
  }
  if (strangers.empty()) return;
  store_->skip_jobs(*strangers.rbegin());
  log::warn(
      "{} holds {} folders of jobs that the database does not know, {} to {}: they are left as "
      "they are, and new jobs are numbered above them",
      (settings_.data / "jobs").string(), strangers.size(), *strangers.begin(),
      *strangers.rbegin());
}

}  // namespace tessera::server
