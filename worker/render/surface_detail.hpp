#pragma once
#include <array>
#include <cstdint>

#include "worker/accel/accel.hpp"
#include "worker/render/frame.hpp"
#include "worker/render/vec.hpp"

/// What materials may look at beyond a surface's normals: only geometry whose material wants it,
/// and that has it, keeps and computes it.
namespace tessera::render {

struct Geometry;
struct Placement;

/// What a material wants, and what a geometry keeps for it: bits.
namespace detail_flag {
constexpr std::uint8_t uv0 = 1, uv1 = 2, tangent = 4, color = 8;
constexpr std::uint8_t tangent_by_uv1 = 16;  ///< tangents follow set 1, not set 0
}  // namespace detail_flag
/// Which set of coordinates tangents follow.
constexpr std::size_t tangent_set(std::uint8_t details) {
  return (details & detail_flag::tangent_by_uv1) != 0 ? 1 : 0;
}

/// Texture coordinates at a hit. (0, 0) is the picture's upper left corner and v runs down.
struct TexturePoint {
  Vec2 uv;
  /// How they change over the width of the ray's cone where it cuts the surface: along the short
  /// and the long axis of that ellipse. 0: the cone has no width, or they do not change.
  Vec2 across, along;
  /// How they change per unit of length along SurfaceDetail's tangent and bitangent, where those
  /// are wanted.
  Vec2 by_tangent, by_bitangent;
};

/// Of a hit; all in the world.
struct SurfaceDetail {
  std::uint8_t has = 0;  ///< what of it the geometry has (detail_flag)
  /// Set 1 is set 0 where the geometry has none.
  std::array<TexturePoint, 2> uv;
  /// Unit, at right angles to the shading normal n and to each other: tangent points where u of
  /// tangent_set(has) grows, bitangent to the picture's top, against v. A tangent-space normal
  /// (x, y, z) is tangent·x + bitangent·y + n·z, as in glTF, mirrored pictures included.
  Vec3 tangent{1, 0, 0}, bitangent{0, 1, 0};
  Color color = gray(1);  ///< the vertices', linear, 0…1
  float alpha = 1;        ///< the vertices', 0…1

  /// There are coordinates of this set, or such that stand in for them.
  [[nodiscard]] bool has_uv(std::uint8_t set) const {
    return (has & (set == 0 ? detail_flag::uv0 : detail_flag::uv0 | detail_flag::uv1)) != 0;
  }
  [[nodiscard]] bool has_tangents() const { return (has & detail_flag::tangent) != 0; }
  /// Tangent, bitangent and n, the two turned about another normal than the hit's; left-handed
  /// where the picture is mirrored. Any axes where there are no tangents.
  [[nodiscard]] Frame tangents_about(const Vec3& n) const;
};

/// Where a ray's cone cuts a surface.
struct ConeCut {
  Vec3 direction;  ///< of the ray, unit
  Vec3 normal;     ///< geometric, unit
  Vec3 shading;    ///< normal, unit
  float width = 0;
};

/// What `geometry.details` names, at a hit of it.
SurfaceDetail detail_at(const Geometry& geometry, const Placement& placement, const accel::Hit& hit,
                        const ConeCut& cut);

/// Coordinates alone, of set 0 or 1: for what is asked while a ray is still on its way.
Vec2 uv_at(const Geometry& geometry, const accel::Hit& hit, std::uint8_t uv_set);
/// The same of set 0, also where no material wants it; (0, 0) where the geometry has none.
Vec2 surface_uv(const Geometry& geometry, const accel::Hit& hit);
/// The vertices' alpha alone; 1 where the geometry has no colours.
float vertex_alpha_at(const Geometry& geometry, const accel::Hit& hit);

/// A unit tangent and its bitangent's sign in 32 bits; 0 becomes no_tangent.
std::uint32_t encode_tangent(const Vec3& unit, bool negative);
/// Of a vertex whose faces do not agree on one: hits take their face's.
constexpr std::uint32_t no_tangent = 0xffffffff;

}  // namespace tessera::render
