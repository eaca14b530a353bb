#pragma once
#include <memory>
#include <mutex>
#include <set>
#include <stop_token>
#include <string>

#include "common/assets/blob_store.hpp"
#include "common/assets/bundle.hpp"
#include "common/base/clock.hpp"
#include "worker/agent/renderer.hpp"

/// Brings a job's blobs into the cache.
namespace tessera::agent {

struct FetchSettings {
  std::uint64_t cache_bytes = 10ULL << 30;
  int tries = 4;  ///< of each blob, that bring nothing of it, one after another
  Duration first_wait = std::chrono::milliseconds(250);  ///< between tries; doubled each time
};

/// A bundle whose files are all here, and stay as long as this lives.
struct FetchedBundle {
  assets::Bundle bundle;
  SceneFiles files;
  std::unique_ptr<assets::BlobStore::Pin> bundle_pin, files_pin;
};

class Fetcher {
 public:
  Fetcher(assets::BlobStore& cache, FetchSettings settings) : cache_(cache), settings_(settings) {}

  /// Fetches what is lacking from {blob_url}/v1/blobs/{sha256}, several at once; one that breaks
  /// off goes on where it broke off. Blobs that lay in the cache are read through once before they
  /// are trusted. Blocks; nothing if `stop` was asked for. Throws Error that names the blob.
  std::optional<FetchedBundle> fetch(const Digest& bundle, const std::string& blob_url,
                                     const std::string& token, const Fraction& progress,
                                     std::stop_token stop);

 private:
  bool here(const Digest& digest);

  assets::BlobStore& cache_;
  FetchSettings settings_;
  std::set<Digest> trusted_;  ///< read through, or fetched, by this process
};

}  // namespace tessera::agent
