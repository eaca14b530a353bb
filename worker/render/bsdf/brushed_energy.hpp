#pragma once
#include "worker/render/bsdf/energy.hpp"
#include "worker/render/bsdf/ggx.hpp"

/// energy.hpp's numbers of a surface that reflects, for any pair of αx and αy. Of one that is
/// brushed in a direction they depend on the azimuth too. Tables over cosine and azimuth stand on a
/// lattice of the greater α and the ratio of the two; each is made, in some milliseconds, when it
/// is first asked for. The albedo that they give is off by at most .004 where cosines are not
/// below .05.
namespace tessera::render::energy {

/// A direction as such a surface sees it: both its sides and all four quarters are alike.
struct Slant {
  float cosine = 1;      ///< against the normal, 0…1
  float along_x = 0.5F;  ///< cos² of the azimuth
};
Slant slant_of(const Vec3& v);

/// Towards `v`, whose slant is asked for only where it matters.
float reflection(const Vec3& v, const ggx::Roughness& roughness);
Bounce bounce(const Slant& slant, const ggx::Roughness& roughness);
float reflection_mean(const ggx::Roughness& roughness);
void prepare_reflection(const ggx::Roughness& roughness);

}  // namespace tessera::render::energy
