#pragma once
#include <limits>

#include "worker/render/vec.hpp"

namespace tessera::render {

/// Limits of what one contribution to a sample may have, as the mean of its R, G and B; brighter
/// ones keep their colour. Biased: off unless asked for.
struct LightClamp {
  static constexpr float off = std::numeric_limits<float>::infinity();
  float direct = off;    ///< of light that met one surface
  float indirect = off;  ///< … several

  /// By the job's settings, in which 0 is off.
  static LightClamp of(double direct, double indirect) {
    const auto limit = [](double value) { return value > 0 ? static_cast<float>(value) : off; };
    return {limit(direct), limit(indirect)};
  }
  /// What is left of light that met `depth` surfaces. What the camera sees shine itself is never
  /// clamped.
  [[nodiscard]] Color operator()(const Color& light, int depth) const {
    const float limit = depth == 0 ? off : depth == 1 ? direct : indirect;
    const float mean = (light.r + light.g + light.b) * (1.0F / 3);
    return mean > limit ? light * (limit / mean) : light;
  }
};

}  // namespace tessera::render
