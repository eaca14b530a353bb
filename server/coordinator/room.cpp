#include <sys/statvfs.h>

#include "common/assets/bundle.hpp"
#include "common/base/limits.hpp"
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
constexpr std::int64_t upload_age = 7 * 24 * 3600;   // seconds
constexpr std::int64_t upload_age_when_full = 3600;
constexpr Duration grace_when_full = std::chrono::hours(1);

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

/// Everything that the bundle names, itself too. What cannot be read names nothing.
void add_needed(const assets::BlobStore& blobs, const Digest& bundle, std::set<Digest>& needed) {
  needed.insert(bundle);
  if (!blobs.has(bundle)) return;
  const assets::Bundle files = assets::bundle_from_json(
      blobs.read(bundle, limits::bundle_json_bytes), "bundle " + bundle.hex());
  for (const Digest& digest : assets::blobs_of(files)) needed.insert(digest);
}

}  // namespace

std::string CoordinatorImpl::lacks_room(std::uint64_t more) const {
  return refusal_of(storage(), reserve_, more);
}

StorageUse CoordinatorImpl::storage() const {
  StorageUse use = measured_;
  use.journal = store_->journal_bytes();
  use.checkpoints = store_->checkpoint_bytes();
  use.films = films_.memory() + settling_.used();
  use.films_most = settings_.film_memory;
  use.disk_most = settings_.disk_limit;
  use.blob_cache_most = settings_.blob_cache;
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
  // Many files take their time; without a limit nobody waits for their sum.
  measured_ = look_at_disk({}, settings_.disk_limit > 0);
  crew_.start("the data folder's upkeep", keep_house());
}

boost::asio::awaitable<void> CoordinatorImpl::keep_house() {
  co_await measure(true);
  for (std::uint64_t look = 0; !crew_.stopping(); ++look) {
    co_await crew_.pause(settings_.upkeep);
    if (crew_.stopping()) co_return;
    // What fails in one of these must not keep the others from their part.
    co_await forget_expired();
    if (look % looks_per_collection == 0 || collect_soon_) co_await collect_blobs();
    co_await measure(look % looks_per_walk == 0 || settings_.disk_limit > 0);
  }
}

boost::asio::awaitable<void> CoordinatorImpl::measure(bool walk) {
  const std::function<StorageUse()> look = [this, walk, before = measured_] {
    return look_at_disk(before, walk);
  };
  try {
    measured_ = co_await on<StorageUse>(upkeep_, look);
  } catch (const std::exception& error) {
    log::warn("how full the disk is could not be seen: {}", error.what());
  }
}

boost::asio::awaitable<void> CoordinatorImpl::collect_blobs() {
  collect_soon_ = false;
  std::set<Digest> bundles;
  for (const auto& [id, job] : jobs_)
    if (job.record.state != "failed" && job.record.state != "cancelled")
      bundles.insert(job.record.spec.bundle);
  const bool short_of_room = !lacks_room(0).empty();
  const Duration grace =
      short_of_room ? std::min(settings_.blob_grace, grace_when_full) : settings_.blob_grace;
  const std::uint64_t most = short_of_room ? 0 : settings_.blob_cache;
  using Evicted = assets::BlobStore::Evicted;
  const std::function<Evicted()> collect = [this, bundles, grace, most] {
    std::set<Digest> needed;
    for (const Digest& bundle : bundles) add_needed(blobs_, bundle, needed);
    using FileTime = std::filesystem::file_time_type;
    const FileTime young =
        FileTime::clock::now() - std::chrono::duration_cast<FileTime::duration>(grace);
    return blobs_.collect(needed, {.most = most, .young = young});
  };
  // An upload that broke off may go on; where room is short it has an hour for that.
  const std::int64_t age = short_of_room ? upload_age_when_full : upload_age;
  const std::function<char()> forget = [this, age] {
    blobs_.remove_partials(age);
    return char{};
  };
  try {
    const Evicted evicted = co_await on<Evicted>(upkeep_, collect);
    measured_.blob_cache = evicted.left;
    measured_.blobs_evicted += evicted.blobs;
    measured_.blob_bytes_evicted += evicted.bytes;
    if (evicted.blobs > 0)
      log::info("{} of blobs that no job needs are removed", bytes_text(evicted.bytes));
  } catch (const std::exception& error) {
    log::warn("blobs that no job needs could not be removed: {}", error.what());
  }
  try {
    co_await on<char>(upkeep_, forget);
  } catch (const std::exception& error) {
    log::warn("uploads that broke off could not be removed: {}", error.what());
  }
}

}  // namespace tessera::server
