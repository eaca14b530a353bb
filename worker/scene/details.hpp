#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "common/scene/description.hpp"
#include "worker/render/scene.hpp"

namespace tessera::worker {

/// What of `wanted` (render::detail_flag) a shape can give, and what is needed to make the rest of
/// it: a second set of coordinates is the first where there is none, and tangents come from
/// the set that they are to follow where none are given. Quads, boxes and spheres have coordinates
/// of their own.
std::uint8_t details_of(const scene::Shape& shape, std::uint8_t wanted);

/// True if it has texture coordinates of set 0 for its vertices.
bool has_coordinates(const scene::Shape& shape);

/// Room for `vertices` in what `details` names; tangents only if `with_tangents`.
void make_room(render::Geometry& geometry, std::uint8_t details, bool with_tangents,
               std::size_t vertices);

/// True if tangents are kept for each vertex: they were given, or can be made smooth from normals
/// and coordinates. Else a hit takes its face's.
bool has_vertex_tangents(const scene::Shape& shape, std::uint8_t details);

/// Where tangents are to be made, parts the vertices that a picture and its mirror image share
/// (tangents.hpp): the mesh has more vertices then.
void part_for_tangents(scene::Shape& shape, std::uint8_t details);

/// Copies a mesh's details behind `first`, where there is room for them. `to_group` turns its
/// tangents.
void add_mesh_details(const scene::Mesh& mesh, std::uint32_t first,
                      const scene::Transform& to_group, render::Geometry& geometry);

/// The coordinates of a box's faces at corner, corner + u, corner + u + v, corner + v of each, in
/// the order −x, −y, −z, +x, +y, +z: seen from outside, the picture's top is towards +y, that of
/// the upper face towards −z, that of the lower towards +z.
using FaceUvs = std::array<render::Vec2, 4>;
const std::array<FaceUvs, 6>& box_uvs();
/// u along edge_u; the picture's top is where edge_v leads.
const FaceUvs& quad_uvs();

}  // namespace tessera::worker
