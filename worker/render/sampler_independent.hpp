#pragma once
#include <array>
#include <cstdint>

#include "worker/render/hash.hpp"

namespace tessera::render {

/// Four independent numbers: a counter-based generator, the hash of (pixel, set, index). It has no
/// state to fill, so it is what plain Monte Carlo costs where numbers are asked for by address.
inline std::array<std::uint32_t, 4> independent_draw(std::uint64_t pixel_hash, std::uint32_t set,
                                                     std::uint64_t index) {
  const std::uint64_t key = draw_key(pixel_hash, set, index);
  const std::uint64_t a = mix64(key + 0x9e3779b97f4a7c15ULL);
  const std::uint64_t b = mix64(key + 2 * 0x9e3779b97f4a7c15ULL);
  return {static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(a >> 32),
          static_cast<std::uint32_t>(b), static_cast<std::uint32_t>(b >> 32)};
}

}  // namespace tessera::render
