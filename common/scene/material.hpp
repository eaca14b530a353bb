#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "common/scene/texture.hpp"

/// What surfaces are made of.
namespace tessera::scene {

/// Diffuse reflection, Lambertian where it is smooth; both sides scatter alike.
struct Diffuse {
  Color reflectance{0.5, 0.5, 0.5};  ///< 0…1
  double roughness = 0;              ///< 0…1, of the EON model; 0 is Lambert's
};
/// Perfect specular reflection.
struct Mirror {
  Color reflectance{1, 1, 1};  ///< 0…1
};
/// A metal, by its complex index of refraction for each of the three colours.
struct Conductor {
  Color eta{0.2, 0.92, 1.1}, k{3.91, 2.45, 2.14};  ///< ≥ 0; against air
  double roughness = 0;                            ///< 0…1; α is its square
  double anisotropy = 0;                           ///< 0…1, as in Principled
  double anisotropy_rotation = 0;                  ///< radians, as in Principled
};
/// The interface of a dielectric; unless it is thin-walled, the shape must be closed for refraction
/// to make sense.
struct Dielectric {
  double ior = 1.5;                  ///< of the inside, > 0
  Color transmittance{1, 1, 1};      ///< multiplies what passes the interface, 0…1
  Color reflectance{1, 1, 1};        ///< multiplies what is reflected, 0…1
  double roughness = 0;              ///< 0…1; α is its square
  bool thin_walled = false;          ///< a pane: two interfaces, nothing is bent
  Color attenuation_color{1, 1, 1};  ///< what is left after attenuation_distance
  double attenuation_distance = 0;   ///< scene lengths; 0: the inside absorbs nothing
};
/// Emits, and may scatter as a diffuse surface besides.
struct Emitter {
  Color radiance{1, 1, 1};     ///< W·sr⁻¹·m⁻², ≥ 0
  bool two_sided = false;      ///< else it emits only on the side of the geometric normal
  Color reflectance{0, 0, 0};  ///< Lambertian, on both sides, 0…1
};

/// The surface that glTF 2.0 and its extensions describe: metallic-roughness, with transmission,
/// clearcoat and the rest. Defaults are a dielectric of ior 1.5, half rough, opaque.
struct Principled {
  ColorInput base_color{.factor = {0.8, 0.8, 0.8}, .texture = {}};  ///< 0…1
  ScalarInput metallic{.factor = 0};                                ///< 0…1
  ScalarInput roughness{.factor = 0.5};                             ///< 0…1; α is its square
  double ior = 1.5;                                                 ///< ≥ 1
  ScalarInput specular;                          ///< KHR_materials_specular's strength, 0…1
  ColorInput specular_color;                     ///< of the dielectric's F0, ≥ 0
  ScalarInput transmission{.factor = 0};         ///< 0…1
  bool thin_walled = true;                       ///< no volume behind it: nothing is bent
  Color attenuation_color{1, 1, 1};              ///< what is left after attenuation_distance
  double attenuation_distance = 0;               ///< scene lengths; 0: the inside absorbs nothing
  ScalarInput clearcoat{.factor = 0};            ///< 0…1
  ScalarInput clearcoat_roughness{.factor = 0};  ///< 0…1
  std::optional<NormalMap> clearcoat_normal;
  ScalarInput anisotropy{.factor = 0};             ///< KHR_materials_anisotropy's strength, 0…1
  double anisotropy_rotation = 0;                  ///< radians, counter-clockwise from the tangent
  std::optional<TextureUse> anisotropy_direction;  ///< R, G: direction·½ + ½; times B: strength
  ColorInput emission{.factor = {0, 0, 0}, .texture = {}};  ///< radiance
  bool unlit = false;  ///< base colour is emitted to every side, and nothing scatters
};

/// What share of a surface is there: the base colour's alpha, or any number.
struct Opacity {
  enum class Mode : std::uint8_t {
    opaque,  ///< always there
    mask,    ///< there where alpha is at least `cutoff`
    blend    ///< there with probability alpha
  };
  Mode mode = Mode::opaque;
  double cutoff = 0.5;
  ScalarInput alpha;
};

/// Two other materials, of which each does its part. Neither may be a mix itself, or emit.
struct Mix {
  std::uint32_t first = 0, second = 0;  ///< indices into Scene::materials
  ScalarInput amount{.factor = 0.5};    ///< of the second, 0…1
};

struct Material {
  std::string name;
  std::variant<Diffuse, Mirror, Dielectric, Emitter, Conductor, Principled, Mix> surface;
  Opacity opacity;
  std::optional<NormalMap> normal_map;
  std::optional<BumpMap> bump_map;
  bool vertex_colors = true;  ///< a mesh's colours multiply base colour and alpha, where it has any
  /// Sees only the side of the geometric normal; the other is not there.
  bool back_culled = false;
  std::int32_t priority = 0;  ///< of nested dielectrics: where several overlap the greatest counts
  std::string light_group = {};  ///< of what it emits; empty: the default group
};

/// True if light may come from the material itself, and not for the eye alone.
bool is_light(const Material& material);

}  // namespace tessera::scene
