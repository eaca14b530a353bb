#include "worker/render/lights/alias_table.hpp"

namespace tessera::render {

AliasTable::AliasTable(std::span<const double> weights) : pmf_(weights.size(), 0.0F) {
  constexpr double whole = 0x1p32;
  const std::size_t n = weights.size();
  double total = 0;
  for (const double weight : weights) total += weight;
  if (!(total > 0)) return;

  // Vose, "A linear algorithm for generating random numbers with a given distribution", 1991.
  buckets_.resize(n);
  std::vector<double> share(n);
  std::vector<std::uint32_t> small, large;
  for (std::size_t i = 0; i < n; ++i) {
    share[i] = weights[i] * (static_cast<double>(n) / total);
    (share[i] < 1 ? small : large).push_back(static_cast<std::uint32_t>(i));
  }
  // Of 2^32 numbers, those that stay with the bucket's own thing.
  std::vector<double> own(n, whole);
  for (std::size_t i = 0; i < n; ++i) buckets_[i].alias = static_cast<std::uint32_t>(i);
  while (!small.empty() && !large.empty()) {
    const std::uint32_t poor = small.back(), rich = large.back();
    small.pop_back();
    const auto threshold = static_cast<std::uint32_t>(share[poor] * (whole - 1));
    buckets_[poor] = {.threshold = threshold, .alias = rich};
    own[poor] = threshold;
    share[rich] -= 1 - share[poor];
    if (share[rich] < 1) {
      large.pop_back();
      small.push_back(rich);
    }
  }

  // What pick() truly does, thresholds rounded as they are.
  std::vector<double> numbers(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    numbers[i] += own[i];
    numbers[buckets_[i].alias] += whole - own[i];
  }
  for (std::size_t i = 0; i < n; ++i) {
    pmf_[i] = static_cast<float>(numbers[i] / (whole * static_cast<double>(n)));
  }
}

AliasTable::Pick AliasTable::pick(std::uint32_t bits) const {
  if (buckets_.empty()) return {};
  const std::uint64_t scaled = static_cast<std::uint64_t>(bits) * buckets_.size();
  const auto index = static_cast<std::uint32_t>(scaled >> 32);
  const Bucket& bucket = buckets_[index];
  const std::uint32_t chosen =
      static_cast<std::uint32_t>(scaled) < bucket.threshold ? index : bucket.alias;
  return {.index = chosen, .pmf = pmf_[chosen]};
}

}  // namespace tessera::render
