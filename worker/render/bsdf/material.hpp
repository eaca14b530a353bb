#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "common/scene/description.hpp"
#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/bsdf/normal_map.hpp"
#include "worker/render/bsdf/shading_point.hpp"
#include "worker/render/bsdf/surfaces.hpp"

namespace tessera::render {

/// One step of a material's program.
struct Instruction {
  enum class Code : std::uint8_t {
    lobe,            ///< add `lobe`, which is the same at every hit
    emit,            ///< add `radiance` on the outer side
    emit_two_sided,  ///< add `radiance` on both sides
    surface          ///< run surface `surface`
  };
  Code code = Code::lobe;
  std::uint8_t surface = 0;
  Lobe lobe;
  Color radiance;
};

/// What stands behind an interface.
struct Medium {
  float ior = 1;
  std::int32_t priority = 0;  ///< where several overlap, the greatest counts
  Color absorption;           ///< per unit of length
};

/// A material as the renderer runs it: a flat program. No string or virtual call at a hit, and no
/// heap.
struct CompiledMaterial {
  static constexpr int instructions_max = Closure::lobes_max + 4;
  std::array<Instruction, instructions_max> program;
  int count = 0;
  std::vector<Surface> surfaces;  ///< of the steps that name one
  /// The emitted radiance, which `radiance_texture` multiplies where there is one; black: no light
  /// is to be made of its shapes.
  Color radiance;
  std::optional<TextureUse> radiance_texture;
  /// What leaves a point is not everywhere and in all directions the same: emission() tells.
  bool radiance_varies = false;
  bool two_sided = false;         ///< emits on both sides
  std::uint16_t light_group = 0;  ///< of what it emits; index into Scene::light_groups
  /// Which details of a surface it looks at (detail_flag); what a geometry has of others is not
  /// kept.
  std::uint8_t wants = 0;
  /// There is another medium behind it: `medium`.
  bool interface = false;
  /// It may be not there, by `opacity`; or, from inside, never is.
  bool has_opacity = false, back_culled = false;
  Medium medium;
  scene::Opacity::Mode opacity = scene::Opacity::Mode::opaque;
  float cutoff = 0;
  ScalarSlot alpha;
  bool vertex_alpha = false;
  std::optional<NormalSlot> normal_map;
  std::optional<BumpSlot> bump_map;

  bool bends_normals = false;  ///< there is a map of either kind
  /// A path may go on behind it as if nothing were there: an interface, or by the two above.
  bool may_pass = false;

  [[nodiscard]] bool emits() const { return !is_black(radiance); }
};

/// Compiles by the table in material.cpp, one entry per material of the description. `all` are the
/// scene's materials, which a mix names.
CompiledMaterial compile(const scene::Material& material,
                         std::span<const scene::Material> all = {});
/// The names of the table, in the order of the description's variant.
std::vector<std::string_view> material_names();

/// Runs the program at a hit. `out` is cleared first.
void evaluate(const CompiledMaterial& material, const TextureTable& textures,
              const ShadingPoint& point, Closure& out);
/// The radiance that a point sends to wo, times the share of the surface that is there.
Color emission(const CompiledMaterial& material, const TextureTable& textures,
               const ShadingPoint& point);
/// The share of the surface that is there for light from or to wo, 0…1.
float presence(const CompiledMaterial& material, const TextureTable& textures,
               const ShadingPoint& point);

}  // namespace tessera::render
