#include <sys/statvfs.h>

#include "common/assets/bundle.hpp"
#include "common/base/log.hpp"
#include "server/coordinator/frame_file.hpp"
#include "server/coordinator/impl.hpp"
#include "server/coordinator/storage_policy.hpp"

/// What is kept, for how long, and how much of it there may be.
namespace tessera::server {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t looks_per_walk = 12;         // with the usual pause: a minute
constexpr std::uint64_t looks_per_collection = 120;  // ten

std::uint64_t bytes_below(const fs::path& folder) {
  std::uint64_t total = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code gone;
    const std::uintmax_t size = entry->is_regular_file(gone) ? entry->file_size(gone) : 0;
    if (!gone) total += size;
  }
  return total;
}

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

/// Everything that the bundle names, itself too. What cannot be read names nothing.
void add_needed(const assets::BlobStore& blobs, const Digest& bundle, std::set<Digest>& needed) {
  needed.insert(bundle);
  if (!blobs.has(bundle)) return;
  const assets::Bundle files = assets::bundle_from_json(
      blobs.read(bundle, assets::bundle_json_most), "bundle " + bundle.hex());
  for (const Digest& digest : assets::digests_of(files)) needed.insert(digest);
}

}  // namespace

std::string CoordinatorImpl::lacks_room() const { return refusal_of(storage(), reserve_); }

StorageUse CoordinatorImpl::storage() const {
  StorageUse use = measured_;
  use.journal = store_->journal_bytes();
  use.checkpoints = store_->checkpoint_bytes();
  use.films = films_.memory();
  use.films_most = settings_.film_memory;
  use.disk_most = settings_.disk_limit;
  return use;
}

StorageUse CoordinatorImpl::look_at_disk(StorageUse use, bool walk) const {
  struct statvfs system {};
  if (statvfs(settings_.data.c_str(), &system) == 0)
    use.disk_free = std::uint64_t{system.f_bavail} * system.f_frsize;
  if (!walk) return use;
  use.blobs = blobs_.bytes();
  use.pictures = bytes_below(settings_.data / "jobs");
  return use;
}

void CoordinatorImpl::begin_house() {
  struct statvfs system {};
  if (statvfs(settings_.data.c_str(), &system) == 0)
    reserve_ = reserve_of(std::uint64_t{system.f_blocks} * system.f_frsize, settings_.disk_reserve);
  measured_ = look_at_disk({}, true);
  crew_.start("the data folder's upkeep", keep_house());
}

boost::asio::awaitable<void> CoordinatorImpl::keep_house() {
  for (std::uint64_t look = 0; !crew_.stopping(); ++look) {
    co_await crew_.pause(settings_.upkeep);
    if (crew_.stopping()) co_return;
    try {
      co_await forget_expired();
      if (look % looks_per_collection == 0 || collect_soon_) co_await collect_blobs();
      const bool walk = look % looks_per_walk == 0 || settings_.disk_limit > 0;
      const std::function<StorageUse()> measure = [this, walk, before = measured_] {
        return look_at_disk(before, walk);
      };
      measured_ = co_await on<StorageUse>(upkeep_, measure);
    } catch (const std::exception& error) {
      log::warn("the data folder could not be looked after: {}", error.what());
    }
  }
}

boost::asio::awaitable<void> CoordinatorImpl::collect_blobs() {
  collect_soon_ = false;
  std::set<Digest> bundles;
  for (const auto& [id, job] : jobs_)
    if (job.record.state != "failed" && job.record.state != "cancelled")
      bundles.insert(job.record.spec.bundle);
  const auto grace = std::chrono::duration_cast<std::chrono::seconds>(settings_.blob_grace).count();
  const std::function<std::uint64_t()> collect = [this, bundles, grace] {
    std::set<Digest> needed;
    for (const Digest& bundle : bundles) add_needed(blobs_, bundle, needed);
    return blobs_.collect(needed, grace);
  };
  const std::uint64_t removed = co_await on<std::uint64_t>(upkeep_, collect);
  if (removed > 0) log::info("{} of blobs that no job needs are removed", bytes_text(removed));
}

boost::asio::awaitable<void> CoordinatorImpl::forget_expired() {
  std::vector<JobId> expired;
  for (const auto& [id, job] : jobs_)
    if (job.ended && job.at_work == 0 && job.arriving == 0 && !job.extending &&
        has_expired(job.record.finished, unix_millis_now(), settings_.keep_jobs))
      expired.push_back(id);
  for (const JobId id : expired) {
    Job* job = find(id);
    if (!job || !job->ended || job->at_work > 0 || job->extending) continue;
    job->extending = true;  // so that nobody else changes it
    const std::function<char()> forget = [this, id] {
      try {
        set_aside(settings_.data, id, settings_.durable);
        store_->forget_job(id);
      } catch (const std::exception&) {
        take_back(settings_.data, id);
        throw;
      }
      return char{};
    };
    std::exception_ptr error;
    try {
      co_await on_writer<char>(forget);
    } catch (const std::exception&) {
      error = std::current_exception();
    }
    if (error) known(id).extending = false;
    if (error) std::rethrow_exception(error);
    pictures_.forget(id);
    films_.forget(id);
    requests_.erase(job->record.idempotency_key);
    jobs_.erase(id);
    collect_soon_ = true;
    const std::function<char()> remove = [folder = forgotten_folder(settings_.data, id)] {
      std::error_code ignored;  // the next start removes it
      fs::remove_all(folder, ignored);
      return char{};
    };
    co_await on<char>(upkeep_, remove);
    log::info("job {} is forgotten: it ended longer ago than jobs are kept", id);
  }
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
