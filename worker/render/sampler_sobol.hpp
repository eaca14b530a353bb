#pragma once
#include <array>
#include <cstdint>

namespace tessera::render {

/// Four numbers of the Sobol' sequence at a shuffled index, each Owen-scrambled. Burley, "Practical
/// Hash-based Owen Scrambling", JCGT 9(4), 2020. Shuffling and scrambling are seeded by (pixel,
/// set), so sets and pixels are independent, while every aligned run of 2^k indices of a set keeps
/// the sequence's elementary intervals.
std::array<std::uint32_t, 4> sobol_owen_draw(std::uint64_t pixel_hash, std::uint32_t set,
                                             std::uint64_t index);

/// Dimension 0 … 3 of the plain Sobol' sequence, as a fraction of 2^32: the definition, one bit at
/// a time (slow; what the tables are made from and tested against). Directions of Joe and Kuo,
/// 2008.
std::uint32_t sobol_plain(std::uint32_t index, std::uint32_t dimension);

}  // namespace tessera::render
