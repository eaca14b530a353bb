#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "worker/render/bsdf/lobe_shares.hpp"
#include "worker/render/identity.hpp"
#include "worker/render/vec.hpp"

namespace tessera::render {

/// The light that a shadow catcher would send back if it were white, and the shadow of everything,
/// or that of catchers alone, lay on it.
struct Caught {
  Color shadowed, unshadowed;
  float coverage = 0;  ///< 1: the sample saw a catcher
};

/// What one sample saw beside the picture and what denoisers want, for jobs that ask for it.
struct SampleExtras {
  Vec3 position;  ///< of the first hit, in the world
  /// Its texture coordinates, and what it belongs to; 0 unless the trace wants them.
  Vec2 uv;
  Identity object, material;
  /// Light by how often it had scattered: never, once, more often.
  Color emission, direct, indirect;
  /// Scattered light by what the first surface did; 0 unless the trace is by_lobe.
  LobeShares by_lobe;
  Caught caught;
  std::vector<Color> by_group;  ///< by light group; or empty: nobody asks

  void add(const Color& light, const LobeShares& first, int depth, std::uint16_t group) {
    (depth == 0 ? emission : depth == 1 ? direct : indirect) += light;
    if (depth > 0) {
      by_lobe.diffuse += light * first.diffuse;
      by_lobe.specular += light * first.specular;
      by_lobe.transmission += light * first.transmission;
    }
    if (!by_group.empty()) by_group[group] += light;
  }
  void clear() {
    position = {};
    uv = {};
    object = material = {};
    emission = direct = indirect = {};
    by_lobe = {};
    caught = {};
    std::fill(by_group.begin(), by_group.end(), Color{});
  }
  /// Where the sum of its light is finite too.
  [[nodiscard]] bool finite() const {
    return is_finite(position) && std::isfinite(uv.x) && std::isfinite(uv.y) &&
           is_finite(caught.shadowed) && is_finite(caught.unshadowed);
  }
};

}  // namespace tessera::render
