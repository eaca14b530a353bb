#pragma once
#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "worker/render/hash.hpp"
#include "worker/render/sampler_sobol.hpp"
#include "worker/render/vec.hpp"

namespace tessera::render {

/// The fixed map of dimensions, in sets of four that are stratified together ("padded"). A
/// dimension is 4·set + place.
///
/// What is drawn together stands in one set, and the pair that matters most stands in its places 0
/// and 1, which form a (0,2)-sequence. The light's choice is in the light's set, not beside the
/// BSDF's numbers: choice and point are stratified jointly, and with N light samples the whole set
/// is drawn at index sample·N + j while the BSDF's stays at `sample`.
namespace dim {
constexpr std::uint32_t film_set = 0;  ///< [film x, film y, lens x, lens y]
constexpr std::uint32_t path_set = 1;  ///< [time, hero channel, -, -]
constexpr std::uint32_t first_bounce_set = 2;
constexpr std::uint32_t sets_per_bounce = 4;

/// [bsdf x, bsdf y, lobe, roulette]; `bounce` counts from 0, the first hit.
constexpr std::uint32_t bsdf_set(std::uint32_t bounce) {
  return first_bounce_set + sets_per_bounce * bounce;
}
/// [light x, light y, light pick, -]; drawn with an index per light sample.
constexpr std::uint32_t light_set(std::uint32_t bounce) { return bsdf_set(bounce) + 1; }
/// [phase x, phase y, distance, -]
constexpr std::uint32_t medium_set(std::uint32_t bounce) { return bsdf_set(bounce) + 2; }
/// [-, -, -, -], for what is to come (subsurface, nested stochastic choices)
constexpr std::uint32_t spare_set(std::uint32_t bounce) { return bsdf_set(bounce) + 3; }

// Places within those sets. Pairs are named by their first place.
constexpr std::uint32_t film = 0, lens = 2;                ///< film_set
constexpr std::uint32_t time = 0, hero = 1;                ///< path_set
constexpr std::uint32_t bsdf = 0, lobe = 2, roulette = 3;  ///< bsdf_set
constexpr std::uint32_t light = 0, light_pick = 2;         ///< light_set
constexpr std::uint32_t phase = 0, distance = 2;           ///< medium_set
}  // namespace dim

/// One draw of a set: four numbers, each as 32 bits and as a float in [0, 1).
class Draw4 {
 public:
  explicit Draw4(const std::array<std::uint32_t, 4>& bits) : bits_(bits) {}
  /// Uniform in [0, 1), a multiple of 2^-24.
  [[nodiscard]] float operator[](std::uint32_t place) const { return unit_float(bits_[place]); }
  /// The numbers at `first` and first + 1.
  [[nodiscard]] Vec2 pair(std::uint32_t first) const {
    return {(*this)[first], (*this)[first + 1]};
  }
  /// All 32 bits, for a choice among more things than a float tells apart.
  [[nodiscard]] std::uint32_t bits(std::uint32_t place) const { return bits_[place]; }

 private:
  std::array<std::uint32_t, 4> bits_;
};

enum class SamplerKind : std::uint8_t {
  sobol_owen,   ///< Burley's shuffled, Owen-scrambled Sobol' sequence
  sobol,        ///< the same, shifted instead of scrambled
  independent,  ///< a hash of its address: plain Monte Carlo, for comparison
  pcg,          ///< plain Monte Carlo, by PCG32 seeded for each address
  xorshift,     ///< the same by xorshift128
  mt19937,      ///< the same by the Mersenne Twister
};

/// From a name of the table in sampler.cpp; throws Error{bad_input} that lists the valid names.
SamplerKind sampler_kind(std::string_view name);
/// The valid names, the default first.
std::vector<std::string_view> sampler_names();

/// Set `set` at `index` by any kind.
[[gnu::noinline]] std::array<std::uint32_t, 4> addressed_draw(SamplerKind kind,
                                                              std::uint64_t pixel_hash,
                                                              std::uint32_t set,
                                                              std::uint64_t index);

/// What names a pixel's numbers. `seed` is the frame's (frame_seed).
constexpr std::uint64_t pixel_hash(std::uint64_t seed, std::uint32_t x, std::uint32_t y) {
  return hash_combine(seed, (static_cast<std::uint64_t>(y) << 32) | x);
}

/// What all samples of one pixel share of their draws by the default sampler: each set's key, made
/// when it is first asked for. For one thread.
class PixelSets {
 public:
  static constexpr std::uint32_t count = 64;  ///< those of the camera and the first 15 bounces

  /// From now on of this pixel.
  void start(std::uint64_t pixel_hash) {
    pixel_hash_ = pixel_hash;
    made_ = 0;
  }
  [[nodiscard]] std::uint64_t pixel() const { return pixel_hash_; }
  /// set < count.
  const SobolSet& operator[](std::uint32_t set) {
    const std::uint64_t bit = std::uint64_t{1} << set;
    if ((made_ & bit) == 0) {
      sets_[set] = sobol_set(pixel_hash_, set);
      made_ |= bit;
    }
    return sets_[set];
  }

 private:
  std::uint64_t pixel_hash_ = 0, made_ = 0;
  std::array<SobolSet, count> sets_;
};

/// The random numbers of one sample of one pixel. A number is a function of (kind, seed, pixel,
/// sample, dimension) alone: it is the same whatever was drawn before, on whichever thread or
/// machine. The object is a value without any stream.
class Sampler {
 public:
  /// `seed` is the frame's (frame_seed). `sample` counts from 0 within the pixel, over all passes.
  Sampler(SamplerKind kind, std::uint64_t seed, std::uint32_t x, std::uint32_t y,
          std::uint64_t sample)
      : pixel_hash_(pixel_hash(seed, x, y)), sample_(sample), kind_(kind) {}
  /// The same numbers in less time, for one of many samples of the pixel whose sets these are; they
  /// must outlive the sampler.
  Sampler(SamplerKind kind, PixelSets& pixel, std::uint64_t sample)
      : pixel_hash_(pixel.pixel()),
        sample_(sample),
        sets_(kind == SamplerKind::sobol_owen && (sample >> 32) == 0 ? &pixel : nullptr),
        reversed_sample_(reverse_bits(static_cast<std::uint32_t>(sample))),
        kind_(kind) {}

  /// The set at this sample's index.
  [[nodiscard]] Draw4 draw4(std::uint32_t set) const {
    return shares(set) ? Draw4(sobol_owen_draw((*sets_)[set], reversed_sample_))
                       : draw_at(set, sample_);
  }
  /// The set for the j-th of n draws that one sample makes of it (0 ≤ j < n): index sample·n + j.
  [[nodiscard]] Draw4 draw4(std::uint32_t set, std::uint32_t j, std::uint32_t n) const {
    if (n == 1) return draw4(set);
    const std::uint64_t index = sample_ * n + j;
    if (shares(set) && (index >> 32) == 0)
      return Draw4(sobol_owen_draw((*sets_)[set], reverse_bits(static_cast<std::uint32_t>(index))));
    return draw_at(set, index);
  }
  /// One dimension, 4·set + place. It costs as much as its whole set.
  [[nodiscard]] float draw1(std::uint32_t dimension) const {
    return draw4(dimension / 4)[dimension % 4];
  }
  /// Dimensions `dimension` and dimension + 1, which must stand in one set.
  [[nodiscard]] Vec2 draw2(std::uint32_t dimension) const {
    return draw4(dimension / 4).pair(dimension % 4);
  }
  /// A hash of (seed, pixel, sample): for numbers that are addressed by something else than a
  /// dimension.
  [[nodiscard]] std::uint64_t hash() const { return hash_combine(pixel_hash_, sample_); }

 private:
  /// The pixel's sets have this one.
  [[nodiscard]] bool shares(std::uint32_t set) const {
    return sets_ != nullptr && set < PixelSets::count;
  }
  [[nodiscard]] Draw4 draw_at(std::uint32_t set, std::uint64_t index) const {
    return Draw4(addressed_draw(kind_, pixel_hash_, set, index));
  }

  std::uint64_t pixel_hash_;
  std::uint64_t sample_;
  PixelSets* sets_ = nullptr;
  std::uint32_t reversed_sample_ = 0;  ///< where there are sets_
  SamplerKind kind_;
};

}  // namespace tessera::render
