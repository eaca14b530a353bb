#pragma once
#include <array>
#include <cstdint>
#include <random>

#include "worker/render/hash.hpp"

namespace tessera::render {

/// The Mersenne Twister, std::mt19937 (Matsumoto and Nishimura, ACM TOMACS 8(1), 1998), seeded anew
/// for each address with 32 bits of its hash: four numbers of a new stream.
///
/// That is what it costs to ask a stateful generator for numbers by address. Each set of four fills
/// 624 words of state by a chain of multiplications and then twists all of them, for the first four
/// numbers that come out; a stream spreads that over 624 numbers and more.
/// tests/bench/sampler_bench measures both ways side by side.
inline std::array<std::uint32_t, 4> mt19937_draw(std::uint64_t pixel_hash, std::uint32_t set,
                                                 std::uint64_t index) {
  std::mt19937 generator(static_cast<std::uint32_t>(draw_key(pixel_hash, set, index) >> 32));
  return four_of(generator);
}

}  // namespace tessera::render
