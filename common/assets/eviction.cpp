#include "common/assets/eviction.hpp"

#include <algorithm>
#include <tuple>

namespace tessera::assets {

std::uint64_t total_size(const std::vector<KeptBlob>& blobs) {
  std::uint64_t total = 0;
  for (const KeptBlob& blob : blobs) total += blob.size;
  return total;
}

std::vector<KeptBlob> to_evict(std::vector<KeptBlob> blobs, const std::set<Digest>& pinned,
                               const EvictionRule& rule) {
  std::uint64_t left = total_size(blobs);
  std::erase_if(blobs, [&](const KeptBlob& blob) {
    return blob.used > rule.young || pinned.contains(blob.digest);
  });
  std::sort(blobs.begin(), blobs.end(), [](const KeptBlob& a, const KeptBlob& b) {
    return std::tie(a.used, a.digest, a.partial) < std::tie(b.used, b.digest, b.partial);
  });
  const auto end = std::find_if(blobs.begin(), blobs.end(), [&](const KeptBlob& blob) {
    if (left <= rule.most) return true;
    left -= blob.size;
    return false;
  });
  blobs.erase(end, blobs.end());
  return blobs;
}

}  // namespace tessera::assets
