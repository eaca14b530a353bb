#pragma once
#include <optional>
#include <variant>

#include "common/scene/material.hpp"
#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/bsdf/fresnel.hpp"
#include "worker/render/bsdf/inputs.hpp"
#include "worker/render/bsdf/normal_map.hpp"

/// Surfaces whose lobes depend on wo or on textures: at a hit each adds its lobes, up to four so
/// that a mix of two fits, to a closure whose shading frame is set. `wants` is what they look at
/// (detail_flag).
namespace tessera::render {

struct ConductorSurface {
  explicit ConductorSurface(const scene::Conductor& source);
  void add(const Source& source, Closure& out) const;

  [[nodiscard]] std::uint8_t wants() const { return anisotropy > 0 ? detail_flag::tangent : 0; }

  Reflectance reflectance;
  float roughness = 0, anisotropy = 0, rotation = 0;
};

struct DielectricSurface {
  explicit DielectricSurface(const scene::Dielectric& source);
  void add(const Source& source, Closure& out) const;

  [[nodiscard]] static std::uint8_t wants() { return 0; }

  Color reflectance, transmittance;
  float ior = 1, roughness = 0;
  bool thin_walled = false;
};

/// What glTF 2.0 describes. From the outside in: the coat, whose directional albedo takes its part
/// from all below; the specular layer of dielectric and metal, which is one lobe, as Schlick's
/// formula is linear in both its colours; and below it, of what the dielectric's specular layer
/// leaves, diffuse light and what passes a thin wall. What passes into a volume has an interface
/// of its own, by Fresnel's equations. Layers take by wo alone ("albedo scaling"), so that
/// everything that is white gives back what it gets; only a stack of layers is not reciprocal.
struct PrincipledSurface {
  PrincipledSurface(const scene::Principled& source, bool uses_vertex_colors);
  void add(const Source& source, Closure& out) const;
  /// What add() adds to a closure's emission.
  [[nodiscard]] Color emitted(const Source& source) const;

  [[nodiscard]] std::uint8_t wants() const;

  ColorSlot base_color, specular_color, emission;
  ScalarSlot metallic, roughness, specular, transmission, coat, coat_roughness, anisotropy;
  std::optional<NormalSlot> coat_normal;
  std::optional<TextureUse> anisotropy_direction;
  float ior = 1.5F, rotation = 0;
  bool thin_walled = true, unlit = false, vertex_colors = true;
  bool matte = false;  ///< nothing but diffuse light and emission, wherever it is hit

 private:
  struct Coat;
  /// How the specular layer is brushed at a hit.
  struct Brushing {
    float strength = 0;
    Vec2 direction{1, 0};  ///< of any length, along the surface's tangent and across
  };
  [[nodiscard]] Brushing brushing_at(const Source& source) const;
  [[nodiscard]] Coat coat_at(const Source& source) const;
  /// The base colour, vertices' colours in it.
  [[nodiscard]] Color tinted_base(const Source& source) const;
  /// What of the light below it the coat leaves.
  static float add_coat(const Coat& coat, Closure& out);
};

/// Ends a part of a mix: what was added since the last such step is multiplied by its share.
struct MixStep {
  [[nodiscard]] std::uint8_t wants() const { return wanted_by(amount); }

  ScalarSlot amount;
  bool second = false;
};

using Surface = std::variant<ConductorSurface, DielectricSurface, PrincipledSurface, MixStep>;

}  // namespace tessera::render
