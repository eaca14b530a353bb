#include "worker/render/sampler_sobol.hpp"

#include <bit>
#include <cstring>

#include "worker/render/hash.hpp"

namespace tessera::render {

namespace {

/// Direction numbers of Joe and Kuo ("Constructing Sobol sequences with better two-dimensional
/// projections", 2008), the first four dimensions: degree and inner coefficients of the primitive
/// polynomial, initial values.
struct Polynomial {
  std::uint32_t degree, coefficients;
  std::array<std::uint32_t, 3> initial;
};
constexpr Polynomial polynomials[4] = {
    {0, 0, {}}, {1, 0, {1, 0, 0}}, {2, 1, {1, 3, 0}}, {3, 1, {1, 3, 1}}};

constexpr std::array<std::uint32_t, 32> directions_of(const Polynomial& p) {
  std::array<std::uint32_t, 32> v{};
  for (std::uint32_t i = 0; i < 32; ++i) {
    if (p.degree == 0) {
      v[i] = 1U << (31 - i);  // the radical inverse of van der Corput
    } else if (i < p.degree) {
      v[i] = p.initial[i] << (31 - i);
    } else {
      v[i] = v[i - p.degree] ^ (v[i - p.degree] >> p.degree);
      for (std::uint32_t k = 1; k < p.degree; ++k) {
        if (((p.coefficients >> (p.degree - 1 - k)) & 1) != 0) v[i] ^= v[i - k];
      }
    }
  }
  return v;
}
constexpr std::array<std::array<std::uint32_t, 32>, 4> directions = {
    directions_of(polynomials[0]), directions_of(polynomials[1]), directions_of(polynomials[2]),
    directions_of(polynomials[3])};

constexpr std::uint32_t reversed(std::uint32_t x) {
  x = __builtin_bswap32(x);
  x = ((x >> 4) & 0x0f0f0f0fU) | ((x & 0x0f0f0f0fU) << 4);
  x = ((x >> 2) & 0x33333333U) | ((x & 0x33333333U) << 2);
  return ((x >> 1) & 0x55555555U) | ((x & 0x55555555U) << 1);
}

/// Four numbers at once, as one 128-bit register.
using Lanes = std::uint32_t __attribute__((vector_size(16)));
using Bytes = std::uint8_t __attribute__((vector_size(16)));

Lanes reversed(Lanes x) {
  const auto bytes = std::bit_cast<Bytes>(x);
  x = std::bit_cast<Lanes>(
      __builtin_shufflevector(bytes, bytes, 3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12));
  x = ((x >> 4) & 0x0f0f0f0fU) | ((x & 0x0f0f0f0fU) << 4);
  x = ((x >> 2) & 0x33333333U) | ((x & 0x33333333U) << 2);
  return ((x >> 1) & 0x55555555U) | ((x & 0x55555555U) << 1);
}

/// Owen's scrambling of bit-reversed numbers: every bit is flipped by a hash of the bits below it.
/// Laine and Karras, "Stratified Sampling for Stochastic Transparency", 2011, with the constants
/// that Vegdahl found to scramble more evenly.
template <class T>
T scramble_reversed(T x, T seed) {
  x ^= x * 0x3d20adeaU;
  x += seed;
  x *= (seed >> 16) | 1U;
  x ^= x * 0x05526c56U;
  x ^= x * 0x53a22864U;
  return x;
}

/// Sobol' points for each value of each byte of the index, the index and the points bit-reversed: a
/// point is the exclusive or of four loads. 16 KiB.
struct Tables {
  alignas(64) std::uint32_t point[4][256][4];
};
constexpr Tables make_tables() {
  Tables tables{};
  for (std::uint32_t byte = 0; byte < 4; ++byte) {
    for (std::uint32_t value = 0; value < 256; ++value) {
      for (std::uint32_t d = 0; d < 4; ++d) {
        std::uint32_t x = 0;
        for (std::uint32_t bit = 0; bit < 8; ++bit) {
          if (((value >> bit) & 1) != 0) x ^= directions[d][31 - (8 * byte + bit)];
        }
        tables.point[byte][value][d] = reversed(x);
      }
    }
  }
  return tables;
}
constexpr Tables tables = make_tables();

/// As one load: the compiler makes four of them otherwise.
Lanes load(const std::uint32_t (&point)[4]) {
  Lanes lanes;
  std::memcpy(&lanes, point, sizeof(lanes));
  return lanes;
}

/// What a set's sequence is shuffled and scrambled by.
std::uint64_t sequence_key(std::uint64_t pixel_hash, std::uint32_t set, std::uint64_t index) {
  const std::uint64_t key = hash_combine(pixel_hash, set);
  // The sequence has 2^32 points; what lies beyond starts another one.
  return (index >> 32) == 0 ? key : hash_combine(key, index >> 32);
}

Lanes seeds_of(std::uint64_t key) {
  const std::uint64_t a = mix64(key + 0x9e3779b97f4a7c15ULL);
  const std::uint64_t b = mix64(key + 2 * 0x9e3779b97f4a7c15ULL);
  return Lanes{static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(a >> 32),
               static_cast<std::uint32_t>(b), static_cast<std::uint32_t>(b >> 32)};
}

/// What the order of a sequence is shuffled by.
std::uint32_t shuffle_of(std::uint64_t key) { return static_cast<std::uint32_t>(key >> 32); }

/// The point at the shuffled index, both bit-reversed.
Lanes shuffled_point(std::uint32_t shuffle, std::uint32_t reversed_index) {
  const std::uint32_t shuffled = scramble_reversed(reversed_index, shuffle);
  return load(tables.point[0][shuffled & 255]) ^ load(tables.point[1][(shuffled >> 8) & 255]) ^
         load(tables.point[2][(shuffled >> 16) & 255]) ^ load(tables.point[3][shuffled >> 24]);
}

}  // namespace

std::uint32_t sobol_plain(std::uint32_t index, std::uint32_t dimension) {
  std::uint32_t x = 0;
  for (std::uint32_t bit = 0; bit < 32; ++bit) {
    if (((index >> bit) & 1) != 0) x ^= directions[dimension][bit];
  }
  return x;
}

std::uint32_t reverse_bits(std::uint32_t x) { return reversed(x); }

SobolSet sobol_set(std::uint64_t pixel_hash, std::uint32_t set) {
  const std::uint64_t key = sequence_key(pixel_hash, set, 0);
  return {.shuffle = shuffle_of(key),
          .scramble = std::bit_cast<std::array<std::uint32_t, 4>>(seeds_of(key))};
}

std::array<std::uint32_t, 4> sobol_owen_draw(const SobolSet& set, std::uint32_t reversed_index) {
  const Lanes point = shuffled_point(set.shuffle, reversed_index);
  return std::bit_cast<std::array<std::uint32_t, 4>>(
      reversed(scramble_reversed(point, std::bit_cast<Lanes>(set.scramble))));
}

std::array<std::uint32_t, 4> sobol_owen_draw(std::uint64_t pixel_hash, std::uint32_t set,
                                             std::uint64_t index) {
  const std::uint64_t key = sequence_key(pixel_hash, set, index);
  const Lanes point = shuffled_point(shuffle_of(key), reversed(static_cast<std::uint32_t>(index)));
  return std::bit_cast<std::array<std::uint32_t, 4>>(
      reversed(scramble_reversed(point, seeds_of(key))));
}

std::array<std::uint32_t, 4> sobol_draw(std::uint64_t pixel_hash, std::uint32_t set,
                                        std::uint64_t index) {
  const std::uint64_t key = sequence_key(pixel_hash, set, index);
  const Lanes point = shuffled_point(shuffle_of(key), reversed(static_cast<std::uint32_t>(index)));
  return std::bit_cast<std::array<std::uint32_t, 4>>(reversed(point ^ seeds_of(key)));
}

}  // namespace tessera::render
