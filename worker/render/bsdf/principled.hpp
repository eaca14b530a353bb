#pragma once
#include <optional>

#include "common/scene/material.hpp"
#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/bsdf/inputs.hpp"
#include "worker/render/bsdf/microfacet.hpp"
#include "worker/render/bsdf/normal_map.hpp"

namespace tessera::render {

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
  /// The specular layer and what is below it, but for where it is seen from.
  struct Layers {
    std::optional<energy::BounceRow> bounces;  ///< where that is made once, of the specular layer
    microfacet::Surface specular;    ///< dielectric and metal, each by its part of the surface
    microfacet::Surface dielectric;  ///< as if it had all of the surface
    bool dielectric_alone = false;   ///< it has
    microfacet::Surface passed;      ///< the thin wall, for what passes it
    Vec2 direction{1, 0};            ///< in which they are brushed, of any length
    Color base;                      ///< of what is below, times the dielectric's part
    float passing = 0;               ///< of what is below: passes a thin wall
    float interface = 0;             ///< of the surface: an interface to a volume
    Color interface_reflectance, interface_transmittance;  ///< times that; seen from outside
  };
  struct Coat;
  /// How the specular layer is brushed at a hit.
  struct Brushing {
    float strength = 0;
    Vec2 direction{1, 0};  ///< of any length, along the surface's tangent and across
  };
  [[nodiscard]] bool is_textured() const;
  [[nodiscard]] Brushing brushing_at(const Source& source) const;
  [[nodiscard]] Layers layers_at(const Source& source) const;
  void add(const Layers& layers, const Source& source, float below, Closure& out) const;
  [[nodiscard]] microfacet::Surface coat_surface_at(const Source& source) const;
  [[nodiscard]] Coat coat_at(const Source& source) const;
  [[nodiscard]] bool has_vertex_color(const Source& source) const;
  /// The base colour, vertices' colours in it.
  [[nodiscard]] Color tinted_base(const Source& source) const;
  /// What of the light below it the coat leaves.
  static float add_coat(const Coat& coat, Closure& out);

  // Made once, of what has no textures; at hits where vertices have colours they are not looked at.
  std::optional<Layers> everywhere_;
  std::optional<microfacet::Surface> coat_everywhere_;
};

}  // namespace tessera::render
