#pragma once
#include <array>
#include <cassert>
#include <cstdint>

#include "worker/render/frame.hpp"
#include "worker/render/vec.hpp"

/// How light scatters at a point of a surface.
///
/// Conventions, for all lobes and closures:
/// - wo and wi are unit vectors that point away from the surface: wo to where the light goes (the
/// camera's side of the path),
///   wi to where it comes from. Closures take them in world space, lobes in the shading frame,
///   where z is the shading normal.
/// - eval() is f(wo, wi)·|cos θi|: the cosine, against the shading normal, is in it.
/// - sample()'s weight is f·|cos θi| / pdf: the cosine is in it, and the pdf and the lobe's choice
/// are divided out.
/// - pdf() is per unit of solid angle of wi, and holds the choice of lobe. Delta lobes (mirror,
/// smooth dielectric, pane) are invisible to
///   eval() and pdf(): they return 0 for them.
/// - Black from eval() means that no light goes this way. A sample with a black weight or pdf 0 is
/// a path's end: take no
///   further step.
namespace tessera::render {

enum class LobeKind : std::uint8_t {
  diffuse,
  mirror,
  dielectric,
  eon,                 ///< rough diffuse
  microfacet,          ///< GGX, reflecting
  microfacet_through,  ///< the same, thrown to the other side of a thin wall
  rough_dielectric,    ///< GGX, reflecting and refracting
  pane,                ///< smooth thin wall: reflects, or passes straight on
};

/// What a lobe can do: bits.
namespace lobe_flag {
constexpr std::uint8_t reflection = 1, transmission = 2, specular = 4;
}
constexpr std::uint8_t lobe_flags(LobeKind kind) {
  switch (kind) {
    case LobeKind::diffuse:
      return lobe_flag::reflection;
    case LobeKind::mirror:
      return lobe_flag::reflection | lobe_flag::specular;
    case LobeKind::dielectric:
    case LobeKind::pane:
      return lobe_flag::reflection | lobe_flag::transmission | lobe_flag::specular;
    case LobeKind::eon:
    case LobeKind::microfacet:
      return lobe_flag::reflection;
    case LobeKind::microfacet_through:
      return lobe_flag::transmission;
    case LobeKind::rough_dielectric:
      return lobe_flag::reflection | lobe_flag::transmission;
  }
  return 0;
}

/// One lobe: which, and its parameters.
struct Lobe {
  LobeKind kind = LobeKind::diffuse;
  std::uint8_t frame = 0;  ///< 0: Closure::shading; else which of Closure::frames, from 1
  /// Diffuse, eon: albedo; mirror, dielectrics, pane: what is reflected is multiplied by this;
  /// microfacet: reflectance along the microfacet's normal.
  Color weight;
  /// Dielectrics, pane: what passes is multiplied by this; microfacet: the rise of its reflectance
  /// (fresnel.hpp); mirror: its albedo, if that is another than its weight; eon: multiplies it
  /// all.
  Color tint;
  float ior =
      1;  ///< dielectric: index on the side away from the normal over that on the normal's side
  // What follows is of the rough ones alone.
  float alpha_x = 0, alpha_y = 0;  ///< of GGX; eon: alpha_x is its roughness
  Color dip;                       ///< microfacet: of its reflectance (fresnel.hpp)
  /// What light that bounced more than once between microfacets is multiplied by, wo's part in it.
  /// Rough dielectric: r of what is reflected, g of what is refracted.
  Color multiple;
  float multiple_share = 0;  ///< the chance with which such light is sampled
};

/// All that scattering at one point needs, evaluated once per hit. Fixed in size; reuse one object
/// from hit to hit (clear()), as only the lobes in use are ever written.
struct Closure {
  static constexpr int lobes_max = 8;

  Frame shading;                      ///< n is the shading normal, on the outer side
  std::array<Frame, 4> frames;        ///< of lobes that have a normal or a tangent of their own
  Vec3 normal{0, 0, 1};               ///< geometric, unit, outer side
  Color emission;                     ///< radiance emitted towards wo
  std::array<Lobe, lobes_max> lobes;  ///< the first `count`
  std::array<float, lobes_max> pick;  ///< relative probability of each; not normalised
  float pick_sum = 0;
  int count = 0;
  std::uint8_t flags = 0;        ///< union of the lobes' flags
  bool has_smooth = false;       ///< some lobe is not a delta: direct light is worth sampling
  bool rounded = false;          ///< light may come from below the face, if above `round_normal`
  Vec3 round_normal;             ///< of what the face stands for; unit, outer side
  std::uint8_t frame_count = 0;  ///< of `frames`

  void clear() {
    emission = {};
    pick_sum = 0;
    count = 0;
    flags = 0;
    has_smooth = false;
    rounded = false;
    frame_count = 0;
  }
  /// A frame for Lobe::frame.
  std::uint8_t add_frame(const Frame& frame) {
    assert(frame_count < frames.size());
    if (frame_count == frames.size()) return 0;
    frames[frame_count] = frame;
    return ++frame_count;
  }
  /// Adds a lobe that is chosen in proportion to its greatest component; one that scatters nothing
  /// is left out.
  void add(const Lobe& lobe) {
    add(lobe, std::max(max_component(lobe.weight), max_component(lobe.tint)));
  }
  /// Adds a lobe that is chosen in proportion to `weight`; none if that is 0.
  void add(const Lobe& lobe, float weight) {
    if (!(weight > 0)) return;
    assert(count < lobes_max);
    if (count == lobes_max) return;
    lobes[static_cast<std::size_t>(count)] = lobe;
    pick[static_cast<std::size_t>(count)] = weight;
    ++count;
    pick_sum += weight;
    const std::uint8_t lobe_flag_bits = lobe_flags(lobe.kind);
    flags = static_cast<std::uint8_t>(flags | lobe_flag_bits);
    has_smooth = has_smooth || (lobe_flag_bits & lobe_flag::specular) == 0;
  }
};

/// All that a lobe does, multiplied.
Lobe scaled(const Lobe& lobe, const Color& by);
/// Multiplies all that the lobes from `first` on do.
void scale(Closure& closure, int first, float by);

/// A direction drawn from a closure.
struct BsdfSample {
  Vec3 wi;        ///< world space, unit
  Color weight;   ///< f·|cos θi| / pdf; black: nothing was sampled
  float pdf = 0;  ///< per solid angle, as pdf() gives it; if specular, the probability of this
                  ///< choice instead
  LobeKind kind = LobeKind::diffuse;  ///< of the lobe that was chosen, even if it gave nothing
  bool specular = false;  ///< from a delta lobe: MIS must not weigh it against light sampling
  bool transmission = false;
  /// Refractive index where wi runs over that where wo runs; 1 if reflected. The weight of a
  /// refraction holds 1/eta²: radiance is squeezed into fewer directions inside. A path multiplies
  /// its η² by eta² and judges roulette by throughput·η².
  float eta = 1;

  explicit operator bool() const { return pdf > 0 && !is_black(weight); }
};

/// u_lobe chooses the lobe (and within a dielectric, reflection or refraction); u the direction.
BsdfSample sample(const Closure& closure, const Vec3& wo, float u_lobe, Vec2 u);
/// What sample() is asked.
struct BsdfRequest {
  const Closure* closure = nullptr;
  Vec3 wo;
  float u_lobe = 0;
  Vec2 u;
};
/// True if wo and wi are on one side of the surface: of the face, or, where that stands for
/// something round which only reflects, of the plane that touches what it stands for.
inline bool on_one_side(const Closure& closure, const Vec3& wo, const Vec3& wi) {
  const float out = dot(wo, closure.normal);
  return out * dot(wi, closure.normal) > 0 ||
         (closure.rounded && out * dot(wi, closure.round_normal) > 0);
}
/// What light from a given direction comes to.
struct Scattering {
  Color value;    ///< f·|cos θi|, summed over the lobes that are not deltas
  float pdf = 0;  ///< the density with which sample() gives wi by such a lobe
};
Scattering scattering(const Closure& closure, const Vec3& wo, const Vec3& wi);
/// What scattering() is asked.
struct ScatteringRequest {
  const Closure* closure = nullptr;
  Vec3 wo, wi;
};
/// One of the two alone.
inline Color eval(const Closure& closure, const Vec3& wo, const Vec3& wi) {
  return scattering(closure, wo, wi).value;
}
inline float pdf(const Closure& closure, const Vec3& wo, const Vec3& wi) {
  return scattering(closure, wo, wi).pdf;
}
/// For the albedo channel, 0…1, as OIDN wants it: the diffuse albedo; for a mirror its reflectance
/// at normal incidence; for glass 1. A surface that only emits has 0.
Color albedo(const Closure& closure);

}  // namespace tessera::render
