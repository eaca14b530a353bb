#pragma once
#include <array>
#include <cstdint>

/// Mixing of integers. All of it is plain arithmetic modulo 2^32 or 2^64, so that the bits are the
/// same everywhere.
namespace tessera::render {

/// A bijection whose output looks random: the finaliser of SplitMix64 (Steele, Lea, Flood, OOPSLA
/// 2014; Stafford's mix 13).
constexpr std::uint64_t mix64(std::uint64_t x) {
  x ^= x >> 30;
  x *= 0xbf58476d1ce4e5b9ULL;
  x ^= x >> 27;
  x *= 0x94d049bb133111ebULL;
  x ^= x >> 31;
  return x;
}
/// Mixes one more value into a hash. Not symmetric: combine(combine(h, a), b) differs from
/// combine(combine(h, b), a).
constexpr std::uint64_t hash_combine(std::uint64_t hash, std::uint64_t value) {
  return mix64(hash ^ (mix64(value + 0x9e3779b97f4a7c15ULL) + 0x9e3779b97f4a7c15ULL));
}
/// A bijection of 32 bits: the output function of PCG (O'Neill 2014), as Jarzynski and Olano
/// recommend it for renderers
/// ("Hash Functions for GPU Rendering", JCGT 9(3), 2020).
constexpr std::uint32_t pcg_hash(std::uint32_t x) {
  const std::uint32_t state = x * 747796405U + 2891336453U;
  const std::uint32_t word = ((state >> ((state >> 28) + 4U)) ^ state) * 277803737U;
  return (word >> 22) ^ word;
}
/// The seed of one frame of a job: frames of an animation must not share their noise.
constexpr std::uint64_t frame_seed(std::uint64_t seed, std::int32_t frame) {
  return hash_combine(seed, static_cast<std::uint32_t>(frame));
}
/// What names one draw: the hash of (seed and pixel, set, index).
constexpr std::uint64_t draw_key(std::uint64_t pixel_hash, std::uint32_t set, std::uint64_t index) {
  return hash_combine(pixel_hash + set, index);
}
/// The next four numbers of a generator.
template <class Generator>
constexpr std::array<std::uint32_t, 4> four_of(Generator& generator) {
  std::array<std::uint32_t, 4> numbers{};
  for (std::uint32_t& number : numbers) number = static_cast<std::uint32_t>(generator());
  return numbers;
}
/// Uniform in [0, 1) from the upper 24 bits; never 1.
constexpr float unit_float(std::uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24F; }

/// A number in [0, 1) for an alpha test. Embree calls filters in any order and perhaps twice, so it
/// is a function of what is hit alone. `sample_hash` is Sampler::hash().
constexpr float alpha_number(std::uint64_t sample_hash, std::uint32_t bounce,
                             std::uint32_t instance, std::uint32_t primitive) {
  const std::uint64_t hit = (static_cast<std::uint64_t>(instance) << 32) | primitive;
  return unit_float(static_cast<std::uint32_t>(hash_combine(sample_hash + bounce, hit) >> 32));
}

}  // namespace tessera::render
