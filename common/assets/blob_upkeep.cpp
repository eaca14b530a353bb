#include <algorithm>
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

std::vector<BlobStore::State::Entry> BlobStore::State::entries() const {
  std::vector<Entry> found;
  for (const fs::directory_entry& folder_entry : fs::directory_iterator(folder)) {
    const std::string begin = folder_entry.path().filename().string();
    if (begin.size() != 2 || !folder_entry.is_directory()) continue;
    for (const fs::directory_entry& file : fs::directory_iterator(folder_entry.path())) {
      const auto digest = Digest::from_hex(begin + file.path().filename().string());
      std::error_code error;
      const std::uintmax_t size = file.file_size(error);
      const auto used = file.last_write_time(error);
      if (digest && !error) found.push_back({.used = used, .digest = *digest, .size = size});
    }
  }
  return found;
}

std::uint64_t BlobStore::State::remove_unused(std::span<const Entry> entries,
                                              std::uint64_t enough) {
  std::uint64_t removed = 0;
  while (!entries.empty() && removed < enough) {
    const auto held = pins.hold();  // nobody pins, or says that he uses one, meanwhile
    const std::set<Digest> pinned = held.pinned();
    const auto batch = entries.first(std::min(entries.size(), removed_at_once));
    for (const Entry& entry : batch) {
      if (removed >= enough) break;
      if (pinned.contains(entry.digest)) continue;
      std::error_code error;
      // Used since it was listed: it stays.
      if (fs::last_write_time(path(entry.digest), error) != entry.used || error) continue;
      if (fs::remove(path(entry.digest), error)) removed += entry.size;
    }
    entries = entries.subspan(batch.size());
  }
  return removed;
}

std::uint64_t BlobStore::evict(std::uint64_t most) {
  using Entry = State::Entry;
  std::vector<Entry> entries = state_->entries();
  std::uint64_t total = 0;
  for (const Entry& entry : entries) total += entry.size;
  if (total <= most) return total;
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return std::pair(a.used, a.digest) < std::pair(b.used, b.digest);
  });
  return total - state_->remove_unused(entries, total - most);
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
  std::uint64_t total = 0;
  for (const State::Entry& entry : state_->entries()) total += entry.size;
  for (const char* part : {"partial", "tmp"})
    for (const fs::directory_entry& entry : fs::directory_iterator(state_->folder / part)) {
      std::error_code error;
      const std::uintmax_t size = entry.file_size(error);
      if (!error) total += size;
    }
  return total;
}

std::uint64_t BlobStore::collect(const std::set<Digest>& needed, std::int64_t older_than_seconds) {
  const auto limit = fs::file_time_type::clock::now() - std::chrono::seconds(older_than_seconds);
  std::vector<State::Entry> entries = state_->entries();
  std::erase_if(entries, [&](const State::Entry& entry) {
    return entry.used > limit || needed.contains(entry.digest);
  });
  return state_->remove_unused(entries, UINT64_MAX);
}

}  // namespace tessera::assets
