#pragma once
#include <cstdint>
#include <filesystem>
#include <set>
#include <vector>

#include "common/base/digest.hpp"

/// Which blobs are forgotten where there may be only so many bytes of them. Pure.
namespace tessera::assets {

/// A blob, or what is kept of an upload that broke off.
struct KeptBlob {
  std::filesystem::file_time_type used;  ///< the last time
  Digest digest;
  std::uint64_t size = 0;  ///< bytes
  bool partial = false;
  bool operator==(const KeptBlob&) const = default;
};

struct EvictionRule {
  std::uint64_t most = 0;  ///< bytes that may stay
  /// What was used after this stays, whatever there is.
  std::filesystem::file_time_type young = std::filesystem::file_time_type::max();
};

std::uint64_t total_size(const std::vector<KeptBlob>& blobs);

/// Those that go, the least recently used first, until the others have at most `rule.most` bytes;
/// never one that is pinned or young.
std::vector<KeptBlob> to_evict(std::vector<KeptBlob> blobs, const std::set<Digest>& pinned,
                               const EvictionRule& rule);

}  // namespace tessera::assets
