#include <algorithm>
#include <mutex>
#include <set>
#include <span>
#include <utility>

#include "common/assets/blob_state.hpp"

/// Which blobs stay: pins, times of use, eviction from a cache, collection in a server's store.
namespace tessera::assets {

namespace {

/// Files that are removed while nobody can pin: others wait no longer than that takes.
constexpr std::size_t removed_at_once = 64;

}  // namespace

BlobStore::Pin::~Pin() { store_.state_->pins.unpin(number_); }

std::unique_ptr<BlobStore::Pin> BlobStore::pin(std::vector<Digest> digests) {
  touch(digests);
  return std::unique_ptr<Pin>(new Pin(*this, state_->pins.pin(std::move(digests))));
}

namespace {

/// Adds the file if `name` is a digest.
void add(std::vector<KeptBlob>& blobs, const fs::directory_entry& file, const std::string& name,
         bool partial) {
  const auto digest = Digest::from_hex(name);
  std::error_code error;
  const std::uintmax_t size = file.file_size(error);
  const auto used = file.last_write_time(error);
  if (digest && !error)
    blobs.push_back({.used = used, .digest = *digest, .size = size, .partial = partial});
}

}  // namespace

std::vector<KeptBlob> BlobStore::State::blobs() const {
  std::vector<KeptBlob> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string begin = entry.path().filename().string();
    if (begin.size() != 2 || !entry.is_directory()) continue;
    for (const fs::directory_entry& file : fs::directory_iterator(entry.path()))
      add(found, file, begin + file.path().filename().string(), false);
  }
  return found;
}

std::vector<KeptBlob> BlobStore::State::partials() const {
  std::vector<KeptBlob> found;
  for (const fs::directory_entry& file : fs::directory_iterator(folder / "partial"))
    add(found, file, file.path().filename().string(), true);
  return found;
}

bool BlobStore::State::remove(const KeptBlob& blob) {
  std::shared_ptr<std::mutex> uploading;
  std::unique_lock<std::mutex> nobody_uploads;
  if (blob.partial) {
    uploading = mutex_of(blob.digest);
    nobody_uploads = std::unique_lock(*uploading, std::try_to_lock);
    if (!nobody_uploads) return false;
  }
  const fs::path file = blob.partial ? partial(blob.digest) : path(blob.digest);
  std::error_code error;
  if (fs::last_write_time(file, error) != blob.used || error) return false;
  return fs::remove(file, error);
}

void BlobStore::State::remove_unused(std::span<const KeptBlob> going, Evicted& done) {
  while (!going.empty()) {
    const auto held = pins.hold();  // nobody pins, or says that he uses one, meanwhile
    const std::set<Digest> pinned = held.pinned();
    const auto batch = going.first(std::min(going.size(), removed_at_once));
    for (const KeptBlob& blob : batch) {
      if (pinned.contains(blob.digest) || !remove(blob)) continue;
      ++done.blobs;
      done.bytes += blob.size;
    }
    going = going.subspan(batch.size());
  }
}

BlobStore::Evicted BlobStore::State::evict(std::vector<KeptBlob> kept, const EvictionRule& rule) {
  const std::set<Digest> pinned = pins.hold().pinned();
  const std::uint64_t total = assets::total_size(kept);
  Evicted done;
  remove_unused(to_evict(std::move(kept), pinned, rule), done);
  done.left = total - done.bytes;
  return done;
}

BlobStore::Evicted BlobStore::evict(std::uint64_t most) {
  return state_->evict(state_->blobs(), {.most = most});
}

void BlobStore::touch(std::span<const Digest> digests) {
  const auto held = state_->pins.hold();  // nothing is collected meanwhile
  for (const Digest& digest : digests) {
    std::error_code ignored;  // those that are not here yet have no time
    fs::last_write_time(path(digest), fs::file_time_type::clock::now(), ignored);
  }
}

std::optional<std::uint64_t> BlobStore::renew(const Digest& digest) {
  touch({&digest, 1});
  return size(digest);
}

std::uint64_t BlobStore::bytes() const {
  std::uint64_t total = assets::total_size(state_->blobs());
  for (const char* part : {"partial", "tmp"})
    for (const fs::directory_entry& entry : fs::directory_iterator(state_->folder / part)) {
      std::error_code error;
      const std::uintmax_t size = entry.file_size(error);
      if (!error) total += size;
    }
  return total;
}

BlobStore::Evicted BlobStore::collect(const std::set<Digest>& needed, const EvictionRule& rule) {
  std::vector<KeptBlob> kept = state_->blobs();
  std::erase_if(kept, [&](const KeptBlob& blob) { return needed.contains(blob.digest); });
  for (const KeptBlob& partial : state_->partials()) kept.push_back(partial);
  return state_->evict(std::move(kept), rule);
}

}  // namespace tessera::assets
