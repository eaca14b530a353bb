#include "worker/scene/details.hpp"

#include <algorithm>
#include <cmath>

#include "worker/render/surface_detail.hpp"
#include "worker/scene/affine.hpp"
#include "worker/scene/tangents.hpp"

namespace tessera::worker {
namespace {

namespace flag = render::detail_flag;

std::uint8_t with(unsigned bits, unsigned more) { return static_cast<std::uint8_t>(bits | more); }

std::uint16_t share_of(float value) {
  return static_cast<std::uint16_t>(std::lround(std::clamp(value, 0.0F, 1.0F) * 65535.0F));
}

void add_tangents(const scene::Mesh& mesh, std::uint32_t first, const scene::Transform& to_group,
                  render::Geometry& geometry) {
  const std::vector<std::array<float, 4>> made =
      mesh.tangents.empty() ? tangents_of(mesh, render::tangent_set(geometry.details))
                            : std::vector<std::array<float, 4>>{};
  const std::vector<std::array<float, 4>>& tangents = mesh.tangents.empty() ? made : mesh.tangents;
  const Matrix3 m = linear(to_group);
  const bool mirrored = determinant(m) < 0;
  for (std::size_t i = 0; i < tangents.size(); ++i) {
    const auto& t = tangents[i];
    const render::Vec3d turned = times(m, {t[0], t[1], t[2]});
    geometry.tangents[first + i] =
        render::encode_tangent(render::to_float(render::normalize(turned)), (t[3] < 0) != mirrored);
  }
}

}  // namespace

std::uint8_t details_of(const scene::Shape& shape, std::uint8_t wanted) {
  const auto* mesh = std::get_if<scene::Mesh>(&shape.geometry);
  std::uint8_t has = flag::uv0;
  if (mesh != nullptr) {
    has = with(mesh->uvs.empty() ? 0U : flag::uv0, mesh->uvs1.empty() ? 0U : flag::uv1);
    if (!mesh->colors.empty()) has = with(has, flag::color);
  }
  const unsigned second = (has & flag::uv1) != 0 ? flag::uv1 : has & flag::uv0;
  std::uint8_t out = static_cast<std::uint8_t>(wanted & has);
  if ((wanted & flag::uv1) != 0) out = with(out, second);
  if ((wanted & flag::tangent) != 0) {
    const bool given = mesh != nullptr && !mesh->tangents.empty();
    const unsigned set = render::tangent_set(wanted) == 1 ? second : has & flag::uv0;
    if (given || set != 0) out = with(out, flag::tangent | set);
    if (set == flag::uv1) out = with(out, flag::tangent_by_uv1);
  }
  return out;
}

bool has_coordinates(const scene::Shape& shape) {
  const auto* mesh = std::get_if<scene::Mesh>(&shape.geometry);
  if (mesh != nullptr) return !mesh->uvs.empty();
  return !std::holds_alternative<scene::Sphere>(shape.geometry);
}

bool has_vertex_tangents(const scene::Shape& shape, std::uint8_t details) {
  const auto* mesh = std::get_if<scene::Mesh>(&shape.geometry);
  if (mesh == nullptr || (details & flag::tangent) == 0) return false;
  return !mesh->tangents.empty() || !mesh->normals.empty();
}

void part_for_tangents(scene::Shape& shape, std::uint8_t details) {
  auto* mesh = std::get_if<scene::Mesh>(&shape.geometry);
  if (mesh == nullptr || !mesh->tangents.empty() || !has_vertex_tangents(shape, details)) return;
  part_mirrored(*mesh, render::tangent_set(details));
}

void make_room(render::Geometry& geometry, std::uint8_t details, bool with_tangents,
               std::size_t vertices) {
  geometry.details = details;
  if (geometry.kind == render::GeometryKind::spheres) return;
  if ((details & flag::uv0) != 0) geometry.uvs[0].resize(vertices);
  if ((details & flag::uv1) != 0) geometry.uvs[1].resize(vertices);
  if (with_tangents) geometry.tangents.resize(vertices);
  if ((details & flag::color) != 0) geometry.colors.resize(vertices);
}

void add_mesh_details(const scene::Mesh& mesh, std::uint32_t first,
                      const scene::Transform& to_group, render::Geometry& geometry) {
  const auto copy_uvs = [&](const std::vector<std::array<float, 2>>& uvs,
                            accel::LargeVector<render::Vec2>& to) {
    if (to.empty()) return;
    for (std::size_t i = 0; i < uvs.size(); ++i) to[first + i] = {uvs[i][0], uvs[i][1]};
  };
  copy_uvs(mesh.uvs, geometry.uvs[0]);
  copy_uvs(mesh.uvs1, geometry.uvs[1]);
  copy_uvs(mesh.uvs, geometry.spare_uvs);
  if (!geometry.tangents.empty()) add_tangents(mesh, first, to_group, geometry);
  if (geometry.colors.empty()) return;
  for (std::size_t i = 0; i < mesh.colors.size(); ++i) {
    const auto& c = mesh.colors[i];
    geometry.colors[first + i] = {share_of(c[0]), share_of(c[1]), share_of(c[2]), share_of(c[3])};
  }
}

const FaceUvs& quad_uvs() {
  static constexpr FaceUvs uvs{{{0, 1}, {1, 1}, {1, 0}, {0, 0}}};
  return uvs;
}

const std::array<FaceUvs, 6>& box_uvs() {
  // Of a face's two edges one leads to the right or left as seen from outside, one up or down.
  static constexpr FaceUvs right_up{{{0, 1}, {1, 1}, {1, 0}, {0, 0}}};
  static constexpr FaceUvs up_left{{{1, 1}, {1, 0}, {0, 0}, {0, 1}}};
  static constexpr FaceUvs down_right{{{0, 0}, {0, 1}, {1, 1}, {1, 0}}};
  static const std::array<FaceUvs, 6> uvs{right_up, right_up,   up_left,
                                          up_left,  down_right, right_up};
  return uvs;
}

}  // namespace tessera::worker
