#pragma once
#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>

#include "worker/render/bsdf/brushed_energy.hpp"
#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/bsdf/fresnel.hpp"
#include "worker/render/bsdf/ggx.hpp"
#include "worker/render/bsdf/lobe_sample.hpp"

/// Reflection by GGX's microfacets, on whichever side wo is, with the light that bounces between
/// them more than once as a second, diffuse part (Kulla and Conty 2017), so that nothing is lost
/// and the lobe stays reciprocal. Its twin throws the same light to the other side of a thin wall.
namespace tessera::render::microfacet {

/// A surface of microfacets, wherever it is seen from.
struct Surface {
  Reflectance reflectance;
  ggx::Roughness roughness;
  bool smooth = true;  ///< α is too small for a lobe: a mirror, of which what follows says nothing
  float mean = 1;      ///< energy::reflection_mean
  Color later;         ///< what is reflected at all bounces after the first together
  float spread = 0;    ///< 1 / (π·(1 − mean)): what makes of what is lost a lobe
};
Surface surface_of(const Reflectance& reflectance, const ggx::Roughness& roughness);

/// What of it depends on where it is seen from.
struct View {
  float cosine = 1;  ///< of wo, in the lobe's frame, 0…1
  energy::Bounce once{.albedo = 1};
};
inline View view_of(const ggx::Roughness& roughness, const energy::Slant& wo) {
  if (ggx::is_smooth(roughness)) return {.cosine = wo.cosine};
  return {.cosine = wo.cosine, .once = energy::bounce(wo, roughness)};
}
/// The same of a roughness that is no mirror's and has no direction.
inline View view_of(const energy::BounceRow& row, float cosine) {
  return {.cosine = cosine, .once = row.at(cosine)};
}

/// The rough lobe, or the mirror; `through` is the twin of a rough one, whose reflectance is a mere
/// colour.
inline Lobe lobe_of(const Surface& surface, const View& view, bool through = false) {
  const Reflectance& reflectance = surface.reflectance;
  assert(!through || !surface.smooth);
  if (surface.smooth) {
    return {.kind = LobeKind::mirror,
            .weight = reflectance.at(view.cosine),
            .tint = reflectance.normal};
  }
  const float lost = 1 - view.once.albedo;
  return {.kind = through ? LobeKind::microfacet_through : LobeKind::microfacet,
          .weight = reflectance.normal,
          .tint = reflectance.rise,
          .alpha_x = std::max(surface.roughness.alpha_x, ggx::alpha_smooth),
          .alpha_y = std::max(surface.roughness.alpha_y, ggx::alpha_smooth),
          .dip = reflectance.dip,
          .multiple = surface.later * (lost * surface.spread),
          .multiple_share = std::clamp(lost, 0.0F, 1.0F)};
}
/// What such a lobe makes of light to wo: its directional albedo, but for a metal's dip.
inline Color albedo(const Surface& surface, const View& view) {
  const Reflectance& reflectance = surface.reflectance;
  if (surface.smooth) return reflectance.at(view.cosine);
  return (reflectance.normal + reflectance.rise * view.once.schlick) * view.once.albedo +
         surface.later * (1 - view.once.albedo);
}

/// As of a closure that has this lobe alone, in the lobe's frame.
Scattering scattering(const Lobe& lobe, const Vec3& wo, const Vec3& wi);
/// A direction of that density; {0, 0, 0}: none.
Vec3 draw(const Lobe& lobe, const Vec3& wo, float u_part, Vec2 u);

/// Takes calls of scattering() until there are enough of them to go side by side.
class Batch {
 public:
  /// `out` is written now or by answer(), with the bits that scattering() gives.
  void add(const Lobe& lobe, const Vec3& wo, const Vec3& wi, Scattering& out);
  void answer();

 private:
  using Row = std::array<float, WideFloat::lanes>;
  struct Three : std::array<Row, 3> {
    void set(std::size_t lane, float a, float b, float c) {
      (*this)[0][lane] = a;
      (*this)[1][lane] = b;
      (*this)[2][lane] = c;
    }
  };
  /// What calls are made of, a lane for each.
  struct Asked {
    Three wo, wi;  ///< turned up
    Row alpha, share;
    Three normal, rise, dip, multiple;
  };
  std::size_t count_ = 0;
  Asked asked_{};  ///< lanes that nobody asks for hold numbers too
  std::array<Scattering*, WideFloat::lanes> found_{};
};

}  // namespace tessera::render::microfacet
