#pragma once
#include <cmath>
#include <cstdint>

#include "common/image/channels.hpp"
#include "worker/render/light_clamp.hpp"
#include "worker/render/vec.hpp"

namespace tessera::render {

/// What the first surface did with the light of a contribution: for separate outputs.
enum class FirstLobe : std::uint8_t { emission, diffuse, specular, transmission };

/// What one sample saw beside the picture and what denoisers want, for jobs that ask for it.
struct SampleExtras {
  Vec3 position;  ///< of the first hit, in the world

  void clear() { *this = {}; }
  [[nodiscard]] bool finite() const { return is_finite(position); }
};

/// What one sample of one pixel saw. Every contribution comes in by add().
struct SampleRecord {
  LightClamp clamp;
  Color radiance;
  float alpha = 0;
  Color albedo;
  Vec3 normal;
  float z = image::nothing_hit_z;
  SampleExtras* extras = nullptr;  ///< none: nobody asks for them

  /// `depth` is how often the path had scattered; `group` the light's group. One sum is kept now;
  /// separate outputs will sort by the rest.
  void add(const Color& contribution, FirstLobe /*first*/, int depth, std::uint16_t /*group*/) {
    radiance += clamp(contribution, depth);
  }
  /// False if any value is NaN or Inf; then the whole record counts as black.
  [[nodiscard]] bool finite() const {
    return is_finite(radiance) && std::isfinite(alpha) && is_finite(albedo) && is_finite(normal) &&
           std::isfinite(z) && (extras == nullptr || extras->finite());
  }
  /// As nothing seen.
  void clear() {
    SampleRecord empty;
    empty.clamp = clamp;
    empty.extras = extras;
    *this = empty;
    if (extras != nullptr) extras->clear();
  }
};

}  // namespace tessera::render
