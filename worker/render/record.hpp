#pragma once
#include <cmath>
#include <cstdint>

#include "common/image/channels.hpp"
#include "worker/render/extras.hpp"
#include "worker/render/light_clamp.hpp"
#include "worker/render/vec.hpp"

namespace tessera::render {

/// What one sample of one pixel saw. Every contribution comes in by add().
struct SampleRecord {
  LightClamp clamp;
  Color radiance;
  float alpha = 0;
  Color albedo;
  Vec3 normal;
  float z = image::nothing_hit_z;
  SampleExtras* extras = nullptr;  ///< none: nobody asks for them

  /// `first`: what the path's first surface did with it; `depth`: how often it has scattered;
  /// `group`: its light's. Nothing but extras looks at these.
  void add(const Color& light, const LobeShares& first, int depth, std::uint16_t group) {
    const Color kept = clamp(light, depth);
    radiance += kept;
    if (extras != nullptr) extras->add(kept, first, depth, group);
  }
  /// False if any value is NaN or Inf; then the whole record counts as black.
  [[nodiscard]] bool finite() const {
    return is_finite(radiance) && std::isfinite(alpha) && is_finite(albedo) && is_finite(normal) &&
           std::isfinite(z) && (extras == nullptr || extras->finite());
  }
  /// As nothing seen.
  void clear() {
    SampleRecord fresh;
    fresh.clamp = clamp;
    fresh.extras = extras;
    *this = fresh;
    if (extras != nullptr) extras->clear();
  }
};

}  // namespace tessera::render
