#pragma once
#include <array>
#include <cstdint>

#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/bsdf/lobe_shares.hpp"
#include "worker/render/lights/light.hpp"
#include "worker/render/ray.hpp"

namespace tessera::render {

/// What a path is inside of, innermost last. Four deep; what is entered beyond that is forgotten,
/// innermost first kept.
class MediumStack {
 public:
  void enter(std::uint32_t medium) {
    if (count_ < entries_.size()) entries_[count_++] = medium;
  }
  /// Leaves the innermost of that name, in whichever order media were entered.
  void leave(std::uint32_t medium) {
    for (std::size_t i = count_; i-- > 0;) {
      if (entries_[i] != medium) continue;
      for (std::size_t k = i + 1; k < count_; ++k) entries_[k - 1] = entries_[k];
      --count_;
      return;
    }
  }
  /// By what a ray does that meets the boundary: goes in, or comes out.
  void cross(std::uint32_t medium, bool entering) {
    if (entering) {
      enter(medium);
    } else {
      leave(medium);
    }
  }
  [[nodiscard]] std::uint32_t operator[](std::size_t i) const { return entries_[i]; }
  /// no_id: in the open.
  [[nodiscard]] std::uint32_t innermost() const {
    return count_ == 0 ? no_id : entries_[count_ - 1];
  }
  [[nodiscard]] std::size_t size() const { return count_; }

 private:
  std::array<std::uint32_t, 4> entries_{};
  std::size_t count_ = 0;
};

/// All that one path carries from hit to hit.
struct PathState {
  Ray ray;
  Color throughput = gray(1);
  float eta_squared =
      1;  ///< product of squared relative indices: undoes the squeeze of radiance for roulette
  MediumStack media;   ///< named by material
  float last_pdf = 0;  ///< of the direction that the ray took, per solid angle
  LobeKind last_lobe = LobeKind::diffuse;
  bool last_specular = true;  ///< light sampling could not have found what the ray now meets
  LightContext last_context;  ///< where the ray left
  bool undescribed = true;    ///< the surface that AOVs tell of is still to come
  int depth = 0;              ///< how often the path has scattered
  int passes = 0;             ///< how many surfaces it went through that were not there
  float passed_to = 0;        ///< as far along the ray the medium's absorption is paid for
  LobeShares first;           ///< of the first scattering; where nobody asks, nothing
};

}  // namespace tessera::render
