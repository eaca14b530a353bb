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

/// By what a pixel's set is shuffled and scrambled for indices below 2^32: the same for all of its
/// samples.
struct SobolSet {
  std::uint32_t shuffle = 0;
  std::array<std::uint32_t, 4> scramble{};
};
SobolSet sobol_set(std::uint64_t pixel_hash, std::uint32_t set);

std::uint32_t reverse_bits(std::uint32_t x);
/// The same draw as by the pixel and the set's number, of an index whose bits are reversed.
std::array<std::uint32_t, 4> sobol_owen_draw(const SobolSet& set, std::uint32_t reversed_index);

/// The Sobol' sequence without scrambling: only shifted, bit by bit (exclusive or with one number
/// for each dimension, the base-2 form of Cranley and Patterson's rotation; Kollig and Keller,
/// "Efficient Multidimensional Sampling", 2002).
///
/// With neither, all pixels would take the same points: their errors would be alike, and show as
/// structure in the picture instead of as noise; and each mean would be off by the same error,
/// which no number of pixels averages out. The shift makes each pixel's estimate unbiased by
/// itself. It also keeps all elementary intervals. What Owen's scrambling adds is chance within
/// them: errors of smooth integrands fall with the power −3/2 of the number of samples, not with
/// −1.
///
/// Each set uses the same four dimensions. In the same order they would be copies of each other,
/// and a path whose second bounce repeats its first converges to a wrong mean; a shift of the index
/// would not help, as the sequence is linear over bits. So each set goes through the sequence in an
/// order of its own, shuffled by (pixel, set) as for sobol_owen_draw(), within every aligned run of
/// 2^k.
std::array<std::uint32_t, 4> sobol_draw(std::uint64_t pixel_hash, std::uint32_t set,
                                        std::uint64_t index);

/// Dimension 0 … 3 of the plain Sobol' sequence, as a fraction of 2^32: the definition, one bit at
/// a time (slow; what the tables are made from and tested against). Directions of Joe and Kuo,
/// 2008.
std::uint32_t sobol_plain(std::uint32_t index, std::uint32_t dimension);

}  // namespace tessera::render
