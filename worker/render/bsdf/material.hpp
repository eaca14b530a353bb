#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "common/scene/description.hpp"
#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/surface_detail.hpp"

namespace tessera::render {

/// What a material may look at.
struct ShadingPoint {
  Vec3 wo;               ///< unit, away from the surface
  Vec3 normal{0, 0, 1};  ///< geometric, unit, outer side
  Frame shading;         ///< n on the side of `normal`
  float footprint = 0;   ///< width of the ray's cone here, for texture filtering
  /// What CompiledMaterial::wants asked for, where the geometry has any of it.
  std::optional<SurfaceDetail> detail;
};

/// One step of a material's program. Its operands are literals; textures will add steps that fill
/// them.
struct Instruction {
  enum class Code : std::uint8_t {
    lobe,           ///< add `lobe`
    emit,           ///< add `radiance` on the outer side
    emit_two_sided  ///< add `radiance` on both sides
  };
  Code code = Code::lobe;
  Lobe lobe;
  Color radiance;
};

/// A material as the renderer runs it: a flat program of fixed size, no pointer, string or virtual
/// call.
struct CompiledMaterial {
  static constexpr int instructions_max = Closure::lobes_max + 2;
  std::array<Instruction, instructions_max> program;
  int count = 0;
  Color radiance;  ///< the mean emitted radiance; black: no light is to be made of its shapes
  bool two_sided = false;  ///< emits on both sides
  /// Which details of a surface it looks at (detail_flag); what a geometry has of others is not
  /// kept.
  std::uint8_t wants = 0;

  [[nodiscard]] bool emits() const { return !is_black(radiance); }
};

/// Compiles by the table in material.cpp, one entry per material of the description.
CompiledMaterial compile(const scene::Material& material);
/// The names of the table, in the order of the description's variant.
std::vector<std::string_view> material_names();

/// Runs the program at a hit. `out` is cleared first.
void evaluate(const CompiledMaterial& material, const ShadingPoint& point, Closure& out);

}  // namespace tessera::render
