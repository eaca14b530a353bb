#pragma once
#include <array>
#include <cstdint>
#include <limits>

#include "worker/render/hash.hpp"

namespace tessera::render {

/// PCG32 (PCG-XSH-RR 64/32): O'Neill, "PCG: A Family of Simple Fast Space-Efficient Statistically
/// Good Algorithms for Random Number Generation", Harvey Mudd College HMC-CS-2014-0905, 2014. A
/// congruential generator of 64 bits whose increment names one of 2^63 streams; its output is
/// permuted. A UniformRandomBitGenerator.
class Pcg32 {
 public:
  using result_type = std::uint32_t;
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return std::numeric_limits<result_type>::max(); }

  /// As pcg32_srandom of the paper's library.
  constexpr Pcg32(std::uint64_t state, std::uint64_t stream) : increment_((stream << 1) | 1) {
    step();
    state_ += state;
    step();
  }
  constexpr result_type operator()() {
    const std::uint64_t old = state_;
    step();
    const auto shifted = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
    const auto rotation = static_cast<std::uint32_t>(old >> 59);
    return (shifted >> rotation) | (shifted << ((-rotation) & 31));
  }

 private:
  constexpr void step() { state_ = state_ * 6364136223846793005ULL + increment_; }

  std::uint64_t state_ = 0;
  std::uint64_t increment_;
};

/// PCG32 seeded anew for each address: the state is the address's hash, the stream its set. Seeding
/// costs two steps, half as much again as the four numbers themselves; to jump ahead within one
/// stream for each pixel, which the generator can, would take a step for each bit of the distance.
inline std::array<std::uint32_t, 4> pcg_draw(std::uint64_t pixel_hash, std::uint32_t set,
                                             std::uint64_t index) {
  Pcg32 generator(draw_key(pixel_hash, set, index), set);
  return four_of(generator);
}

}  // namespace tessera::render
