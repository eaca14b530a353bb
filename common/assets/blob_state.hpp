#pragma once
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "common/assets/blob_store.hpp"
#include "common/assets/pin_board.hpp"

/// What stands behind BlobStore.
namespace tessera::assets {

namespace fs = std::filesystem;

struct BlobStore::State {
  State(fs::path at, bool safe) : folder(std::move(at)), durable(safe), pins(folder) {}

  fs::path folder;
  bool durable;
  std::mutex mutex;  ///< guards `busy`
  std::map<Digest, std::shared_ptr<std::mutex>>
      busy;  ///< one upload at a time may write a partial file
  PinBoard pins;

  [[nodiscard]] fs::path path(const Digest& digest) const {
    const std::string hex = digest.hex();
    return folder / hex.substr(0, 2) / hex.substr(2);
  }
  [[nodiscard]] fs::path partial(const Digest& digest) const {
    return folder / "partial" / digest.hex();
  }
  [[nodiscard]] std::vector<KeptBlob> blobs() const;
  [[nodiscard]] std::vector<KeptBlob> partials() const;
  /// Removes what the rule says. Holds the pins for a batch at a time.
  Evicted evict(std::vector<KeptBlob> kept, const EvictionRule& rule);
  /// Removes those of them that nobody has pinned or used since they were listed.
  void remove_unused(std::span<const KeptBlob> going, Evicted& done);
  bool remove(const KeptBlob& blob);
  std::shared_ptr<std::mutex> mutex_of(const Digest& digest);
  void give_name(const fs::path& from, const Digest& digest) const;
};

}  // namespace tessera::assets
