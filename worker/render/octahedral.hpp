#pragma once
#include <cmath>
#include <cstdint>

#include "worker/render/vec.hpp"

namespace tessera::render {

/// Unit vectors in 32 bits, 16 for each coordinate of the octahedral map; off by at most 1e-4
/// radians. Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors",
/// JCGT 3(2), 2014.
inline std::uint32_t encode_octahedral(const Vec3& unit) {
  const float sum = std::abs(unit.x) + std::abs(unit.y) + std::abs(unit.z);
  if (!(sum > 0)) return encode_octahedral({0, 0, 1});
  float a = unit.x / sum, b = unit.y / sum;
  if (unit.z < 0) {
    const float folded = (1 - std::abs(b)) * (a < 0 ? -1.0F : 1.0F);
    b = (1 - std::abs(a)) * (b < 0 ? -1.0F : 1.0F);
    a = folded;
  }
  const auto quantise = [](float x) {
    const float scaled = x * 32767.0F;
    return static_cast<std::uint32_t>(static_cast<int>(scaled + (scaled < 0 ? -0.5F : 0.5F)) +
                                      32767);
  };
  return quantise(a) << 16 | quantise(b);
}

inline Vec3 decode_octahedral(std::uint32_t code) {
  const auto back = [](std::uint32_t q) {
    return static_cast<float>(static_cast<int>(q) - 32767) * (1.0F / 32767.0F);
  };
  float a = back(code >> 16), b = back(code & 0xffffU);
  const float z = 1 - std::abs(a) - std::abs(b);
  if (z < 0) {
    const float unfolded = (1 - std::abs(b)) * (a < 0 ? -1.0F : 1.0F);
    b = (1 - std::abs(a)) * (b < 0 ? -1.0F : 1.0F);
    a = unfolded;
  }
  return normalize(Vec3{a, b, z});
}

}  // namespace tessera::render
