#include "worker/agent/fetch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/log.hpp"
#include "worker/agent/download.hpp"

namespace tessera::agent {

bool Fetcher::here(const Digest& digest) {
  if (!cache_.has(digest)) return false;
  if (trusted_.contains(digest)) return true;
  if (!cache_.verify(digest)) {
    log::warn("blob {} in the cache is damaged; it is fetched again", digest.hex());
    return false;
  }
  trusted_.insert(digest);
  return true;
}

void Fetcher::tidy() {
  constexpr std::int64_t day = 24 * 3600;  // nobody writes a file for so long
  cache_.remove_partials(day);
  make_room(0);
}

void Fetcher::make_room(std::uint64_t coming) {
  const std::uint64_t most = settings_.cache_bytes;
  const assets::BlobStore::Evicted evicted = cache_.evict(most - std::min(coming, most));
  use_.bytes = evicted.left;
  use_.evictions += evicted.blobs;
  if (evicted.blobs > 0)
    log::info(
        "{} files that were not used for longest are forgotten, {} bytes; the cache has {} of {}",
        evicted.blobs, evicted.bytes, evicted.left, most);
  if (coming == 0 && evicted.left > most)
    log::warn("the cache has {} bytes, all of scenes in use, and may have {}: --cache-size",
              evicted.left, most);
}

/// One call of fetch().
struct Fetcher::Call {
  const std::string& url;
  const std::string& token;
  const Fraction& progress;
  const std::stop_token& stop;
  double total = 1;        ///< bytes of all files
  std::uint64_t done = 0;  ///< … of those that are here

  void report(std::uint64_t come) const {
    progress(std::min(1.0, static_cast<double>(done + come) / total));
  }
};

void Fetcher::get(const std::vector<Lacking>& blobs, const Call& call,
                  const std::function<void(std::uint64_t)>& on_bytes) {
  Download download(cache_, settings_.patience, blobs, on_bytes);
  download.run(call.url, call.token, call.stop);
  for (const Lacking& blob : blobs) trusted_.insert(blob.digest);
}

void Fetcher::open_shared(FetchedBundle& fetched, Call& call) {
  for (const auto& [path, file] : fetched.bundle.files) {
    if (file.location.empty()) continue;
    const auto report = [&](std::uint64_t come) { call.report(come); };
    std::optional<SharedFile> opened = shared_.open(file, report, call.stop);
    if (!opened) return;
    fetched.files[path] = opened->path();
    fetched.shared.push_back(std::move(*opened));
    call.done += file.size;
  }
}

void Fetcher::get_blobs(FetchedBundle& fetched, Call& call) {
  std::set<Digest> seen;
  std::vector<Lacking> lacking;
  std::uint64_t coming = 0;
  for (const auto& [path, file] : fetched.bundle.files) {
    if (call.stop.stop_requested()) return;
    if (!file.location.empty()) continue;
    fetched.files[path] = cache_.path(file.digest);
    if (!seen.insert(file.digest).second) continue;
    if (here(file.digest)) {
      call.done += file.size;
      call.report(0);
    } else {
      lacking.push_back({file.digest, file.size});
      coming += file.size;
    }
  }
  make_room(coming);
  get(lacking, call, [&](std::uint64_t come) { call.report(come); });
  for (const auto& [path, file] : fetched.bundle.files)
    if (file.location.empty() && cache_.size(file.digest) != file.size)
      throw Error(
          ErrorKind::bad_input,
          fmt::format("the bundle says that the file has {} bytes, its blob has another number",
                      file.size),
          {.file = path});
}

std::optional<FetchedBundle> Fetcher::fetch(const Digest& bundle, const std::string& blob_url,
                                            const std::string& token, const Fraction& progress,
                                            std::stop_token stop) {
  Call call{.url = blob_url, .token = token, .progress = progress, .stop = stop};
  FetchedBundle fetched;
  try {
    fetched.bundle_pin = cache_.pin({bundle});
    if (!here(bundle)) get({{bundle, limits::bundle_json_bytes}}, call, [](std::uint64_t) {});
    fetched.bundle = assets::bundle_from_json(cache_.read(bundle, limits::bundle_json_bytes),
                                              "bundle " + bundle.hex());
    // Pinned before it is looked which are here: none of them goes from now on.
    fetched.files_pin = cache_.pin(assets::blobs_of(fetched.bundle));
    call.total =
        static_cast<double>(std::max<std::uint64_t>(assets::total_size(fetched.bundle), 1));
    open_shared(fetched, call);
    get_blobs(fetched, call);
  } catch (const Error&) {
    if (!stop.stop_requested()) throw;
  }
  if (stop.stop_requested()) return std::nullopt;
  progress(1);
  make_room(0);
  return fetched;
}

}  // namespace tessera::agent
