#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace tessera::render {

/// A choice among things by weight, in constant time: Walker's alias method.
class AliasTable {
 public:
  AliasTable() = default;
  /// Weights ≥ 0. Where none is more, nothing is ever chosen.
  explicit AliasTable(std::span<const double> weights);

  struct Pick {
    std::uint32_t index = 0;
    float pmf = 0;  ///< 0: there is nothing to choose
  };
  /// `bits` is uniform over 32 bits (Draw4::bits): a float's 24 do not tell a million things apart.
  [[nodiscard]] Pick pick(std::uint32_t bits) const;
  /// The probability with which pick() gives this one.
  [[nodiscard]] float pmf(std::uint32_t index) const { return pmf_[index]; }
  [[nodiscard]] bool empty() const { return buckets_.empty(); }

 private:
  struct Bucket {
    std::uint32_t threshold = 0xffffffffU;  ///< the own thing below it, the alias from there on
    std::uint32_t alias = 0;
  };
  std::vector<Bucket> buckets_;
  std::vector<float> pmf_;
};

}  // namespace tessera::render
