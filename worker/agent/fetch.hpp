#pragma once
#include <memory>
#include <mutex>
#include <set>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "common/assets/blob_store.hpp"
#include "common/assets/bundle.hpp"
#include "common/wire/messages.hpp"
#include "worker/agent/download.hpp"
#include "worker/agent/renderer.hpp"
#include "worker/agent/shared_files.hpp"

/// Brings a job's blobs into the cache.
namespace tessera::agent {

struct FetchSettings {
  std::uint64_t cache_bytes = 10ULL << 30;
  std::vector<std::filesystem::path> asset_roots;  ///< as SharedFiles takes them
  Patience patience;
};

/// A bundle whose files are all here, and stay as long as this lives.
struct FetchedBundle {
  assets::Bundle bundle;
  SceneFiles files;
  std::vector<SharedFile> shared;  ///< those that are named by path
  std::unique_ptr<assets::BlobStore::Pin> bundle_pin, files_pin;
};

class Fetcher {
 public:
  Fetcher(assets::BlobStore& cache, FetchSettings settings)
      : cache_(cache), settings_(std::move(settings)), shared_(settings_.asset_roots) {
    use_.most = settings_.cache_bytes;
  }

  /// Fetches what is lacking from {blob_url}/v1/blobs/{sha256}, several at once; one that breaks
  /// off goes on where it broke off. Blobs that lay in the cache are read through once before they
  /// are trusted. Files that are named by path are opened and checked first. Blocks; nothing if
  /// `stop` was asked for. Throws Error that names the blob, and what SharedFiles does.
  std::optional<FetchedBundle> fetch(const Digest& bundle, const std::string& blob_url,
                                     const std::string& token, const Fraction& progress,
                                     std::stop_token stop);
  /// Removes what a process that was killed left half fetched, and what is beyond the limit.
  void tidy();
  [[nodiscard]] const wire::CacheUse& cache() const { return use_; }

 private:
  struct Call;
  bool here(const Digest& digest);
  void get(const std::vector<Lacking>& blobs, const Call& call,
           const std::function<void(std::uint64_t)>& on_bytes);
  void open_shared(FetchedBundle& fetched, Call& call);
  void get_blobs(FetchedBundle& fetched, Call& call);
  /// The least recently used go, until `coming` more fit.
  void make_room(std::uint64_t coming);

  assets::BlobStore& cache_;
  FetchSettings settings_;
  SharedFiles shared_;
  wire::CacheUse use_;
  std::set<Digest> trusted_;  ///< read through, or fetched, by this process
};

}  // namespace tessera::agent
