#pragma once
#include <array>
#include <cstdint>
#include <limits>

#include "worker/render/hash.hpp"

namespace tessera::render {

/// xorshift128, "xor128" of Marsaglia, "Xorshift RNGs", Journal of Statistical Software 8(14),
/// 2003: four words of state, period 2^128 − 1. A UniformRandomBitGenerator.
class Xorshift128 {
 public:
  using result_type = std::uint32_t;
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return std::numeric_limits<result_type>::max(); }

  /// The paper's seeds.
  constexpr Xorshift128() = default;
  /// From any state but zero, which the generator would never leave: that one becomes the paper's.
  constexpr Xorshift128(std::uint64_t low, std::uint64_t high) {
    if ((low | high) == 0) return;
    x_ = static_cast<std::uint32_t>(low);
    y_ = static_cast<std::uint32_t>(low >> 32);
    z_ = static_cast<std::uint32_t>(high);
    w_ = static_cast<std::uint32_t>(high >> 32);
  }
  constexpr result_type operator()() {
    const std::uint32_t t = x_ ^ (x_ << 11);
    x_ = y_;
    y_ = z_;
    z_ = w_;
    w_ = (w_ ^ (w_ >> 19)) ^ (t ^ (t >> 8));
    return w_;
  }

 private:
  std::uint32_t x_ = 123456789, y_ = 362436069, z_ = 521288629, w_ = 88675123;
};

/// xorshift128 seeded anew for each address: its state is 128 bits of hash, and four steps give
/// four numbers. The hash, not the generator, is what costs, and what makes the numbers
/// independent: a step changes only one word, so that streams from like states would run alike for
/// long.
inline std::array<std::uint32_t, 4> xorshift_draw(std::uint64_t pixel_hash, std::uint32_t set,
                                                  std::uint64_t index) {
  const std::uint64_t key = draw_key(pixel_hash, set, index);
  Xorshift128 generator(mix64(key + 0x9e3779b97f4a7c15ULL), mix64(key + 2 * 0x9e3779b97f4a7c15ULL));
  return four_of(generator);
}

}  // namespace tessera::render
