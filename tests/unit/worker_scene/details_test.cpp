#include "worker/scene/details.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "common/scene/texture_uses.hpp"
#include "worker/scene/merge.hpp"
#include "worker/scene/tangents.hpp"

/// What geometry keeps for textures, and what a hit makes of it.
namespace tessera::worker {
namespace {

namespace flag = render::detail_flag;
using render::Geometry;
using render::SurfaceDetail;
using render::Vec3;

constexpr std::uint8_t all = flag::uv0 | flag::uv1 | flag::tangent | flag::color;

Geometry merged(scene::Shape shape, std::uint8_t wants, const scene::Transform& to_group = {},
                bool all_coordinates = false) {
  std::vector<render::CompiledMaterial> materials(1);
  materials[0].wants = wants;
  const PlacedShape placed{&shape, to_group};
  MergedGroup group = merge(std::span(&placed, 1), materials, {}, {}, all_coordinates);
  return std::move(group.group.geometries.at(0));
}

scene::Shape shape_of(decltype(scene::Shape::geometry) geometry) {
  scene::Shape out;
  out.geometry = std::move(geometry);
  return out;
}

/// Two triangles over [0, 2]² at z = 0, uv once over the square, v down.
scene::Mesh square() {
  scene::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
  mesh.uvs = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

accel::Hit hit_at(float u, float v, std::uint32_t primitive = 0) {
  accel::Hit hit;
  hit.geometry = 0;
  hit.primitive = primitive;
  hit.u = u;
  hit.v = v;
  return hit;
}

SurfaceDetail detail(const Geometry& geometry, const accel::Hit& hit,
                     const Vec3& direction = {0, 0, -1}, float width = 0.01F,
                     const Vec3& normal = {0, 0, 1}, const render::Placement& placement = {}) {
  return detail_at(geometry, placement, hit,
                   {.direction = direction, .normal = normal, .shading = normal, .width = width});
}

float length(render::Vec2 v) { return std::sqrt(v.x * v.x + v.y * v.y); }

void expect_near(const Vec3& found, const Vec3& wanted, float tolerance = 1e-3F) {
  EXPECT_NEAR(found.x, wanted.x, tolerance);
  EXPECT_NEAR(found.y, wanted.y, tolerance);
  EXPECT_NEAR(found.z, wanted.z, tolerance);
}

TEST(Details, coordinates_that_no_material_wants_are_kept_for_the_AOV_alone) {
  const auto kept = [](const scene::Shape& shape, std::uint8_t wants, bool all_coordinates) {
    return merged(shape, wants, {}, all_coordinates);
  };
  for (const scene::Shape& shape : {shape_of(square()), shape_of(scene::Quad{})}) {
    const Geometry plain = kept(shape, 0, false), with_aov = kept(shape, 0, true);
    EXPECT_TRUE(plain.spare_uvs.empty() && plain.uvs[0].empty());
    ASSERT_EQ(with_aov.spare_uvs.size(), 4U);
    EXPECT_EQ(with_aov.bytes(), plain.bytes() + 4 * sizeof(render::Vec2));
    EXPECT_EQ(with_aov.details, 0) << "hits do not look at them";
    // Where a texture wants them they are there once.
    for (const bool all_coordinates : {false, true}) {
      const Geometry painted = kept(shape, flag::uv0, all_coordinates);
      EXPECT_TRUE(painted.spare_uvs.empty());
      EXPECT_EQ(painted.uvs[0].size(), 4U);
    }
  }
  scene::Mesh bare = square();
  bare.uvs.clear();
  EXPECT_TRUE(kept(shape_of(bare), 0, true).spare_uvs.empty());
}

scene::Material brushed(double anisotropy, const std::optional<scene::TextureUse>& direction) {
  scene::Principled surface{.anisotropy = {.factor = anisotropy}};
  surface.anisotropy_direction = direction;
  return {"brushed", surface};
}

TEST(Details, that_a_description_foretells_are_those_that_are_kept) {
  const scene::TextureUse by_first, by_second{.uv_set = 1};
  std::vector<scene::Material> materials{
      {"plain", scene::Diffuse{}},
      {"painted", scene::Principled{.base_color = {.texture = by_second}}},
      {"metal", scene::Conductor{.anisotropy = 0.5}},
      {"round metal", scene::Conductor{}},
      brushed(0.5, {}),
      brushed(0.5, by_second),
      {"mixed", scene::Mix{.first = 0, .second = 1, .amount = {.texture = by_first}}},
      {"masked", scene::Diffuse{}, {.mode = scene::Opacity::Mode::mask, .alpha = {1, by_first, 3}}},
      {.name = "bent", .normal_map = scene::NormalMap{by_second}},
      {.name = "bumped", .bump_map = scene::BumpMap{by_first}}};
  scene::Mesh mesh = square();
  mesh.uvs1 = mesh.uvs;
  for (const scene::Material& material : materials) {
    const std::uint8_t wants = render::compile(material, materials).wants;
    const std::uint8_t kept = details_of(shape_of(mesh), wants);
    const std::array<bool, 2> foretold = scene::coordinate_sets(material, materials);
    EXPECT_EQ(foretold[0], (kept & flag::uv0) != 0) << material.name;
    EXPECT_EQ(foretold[1], (kept & flag::uv1) != 0) << material.name;
  }
}

TEST(Details, what_no_material_wants_is_not_kept) {
  scene::Mesh mesh = square();
  mesh.colors.assign(4, {1, 1, 1, 1});
  const Geometry plain = merged(shape_of(mesh), 0);
  EXPECT_EQ(plain.details, 0);
  EXPECT_TRUE(plain.uvs[0].empty() && plain.colors.empty() && plain.tangents.empty());
  const Geometry colored = merged(shape_of(mesh), flag::color);
  EXPECT_EQ(colored.details, flag::color);
  EXPECT_TRUE(colored.uvs[0].empty());
  mesh.colors.clear();
  EXPECT_EQ(merged(shape_of(mesh), flag::color).details, 0);
}

TEST(Details, coordinates_are_interpolated_and_the_second_set_stands_in_for_none) {
  scene::Mesh mesh = square();
  const Geometry one = merged(shape_of(mesh), flag::uv1);
  const SurfaceDetail at = detail(one, hit_at(0.25F, 0.5F));
  EXPECT_FLOAT_EQ(at.uv[0].uv.x, 0.75F);
  EXPECT_FLOAT_EQ(at.uv[0].uv.y, 0.5F);
  EXPECT_EQ(at.uv[1].uv, at.uv[0].uv);
  mesh.uvs1 = {{5, 5}, {6, 5}, {6, 6}, {5, 6}};
  const Geometry two = merged(shape_of(mesh), flag::uv0 | flag::uv1);
  EXPECT_FLOAT_EQ(detail(two, hit_at(0.25F, 0.5F)).uv[1].uv.x, 5.75F);
  EXPECT_FLOAT_EQ(render::uv_at(two, hit_at(0.25F, 0.5F), 1).y, 5.5F);
}

TEST(Details, the_footprint_is_the_cones_cut_with_the_surface) {
  const Geometry geometry = merged(shape_of(square()), flag::uv0);
  const SurfaceDetail straight = detail(geometry, hit_at(0.3F, 0.3F));
  EXPECT_NEAR(length(straight.uv[0].across), 0.005F, 1e-6);  // uv goes once over two units
  EXPECT_NEAR(length(straight.uv[0].along), 0.005F, 1e-6);
  const float c = 0.5F, s = std::sqrt(0.75F);
  const SurfaceDetail slant = detail(geometry, hit_at(0.3F, 0.3F), {s, 0, -c});
  EXPECT_NEAR(length(slant.uv[0].across), 0.005F, 1e-6);
  EXPECT_NEAR(slant.uv[0].along.x, 0.01F, 1e-6);
  EXPECT_NEAR(slant.uv[0].along.y, 0, 1e-6);
  render::Placement larger;
  larger.moved = true;
  larger.to_world = {4, 0, 0, 7, 0, 4, 0, 0, 0, 0, 4, 0};
  const SurfaceDetail far =
      detail(geometry, hit_at(0.3F, 0.3F), {0, 0, -1}, 0.01F, {0, 0, 1}, larger);
  EXPECT_NEAR(length(far.uv[0].across), 0.00125F, 1e-6);
}

TEST(Details, tangents_follow_u_and_bitangents_the_pictures_top) {
  const Geometry flat = merged(shape_of(square()), flag::tangent);
  EXPECT_TRUE(flat.tangents.empty());
  expect_near(detail(flat, hit_at(0.3F, 0.3F)).tangent, {1, 0, 0});
  expect_near(detail(flat, hit_at(0.3F, 0.3F)).bitangent, {0, 1, 0});
  for (const bool mirrored_picture : {false, true}) {
    scene::Mesh mesh = square();
    mesh.normals.assign(4, {0, 0, 1});
    if (mirrored_picture)
      for (auto& uv : mesh.uvs) uv[0] = 1 - uv[0];
    const float along = mirrored_picture ? -1 : 1;
    const Geometry smooth = merged(shape_of(mesh), flag::tangent);
    ASSERT_EQ(smooth.tangents.size(), 4U);
    expect_near(detail(smooth, hit_at(0.3F, 0.3F)).tangent, {along, 0, 0});
    expect_near(detail(smooth, hit_at(0.3F, 0.3F)).bitangent, {0, 1, 0});
    // The picture turns with a mirror that is baked in, and with one of an instance.
    const scene::Transform mirror{{-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    const Geometry baked = merged(shape_of(mesh), flag::tangent, mirror);
    expect_near(detail(baked, hit_at(0.3F, 0.3F)).tangent, {-along, 0, 0});
    expect_near(detail(baked, hit_at(0.3F, 0.3F)).bitangent, {0, 1, 0});
    render::Placement placed;
    placed.moved = true;
    placed.to_world = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    for (const Geometry* geometry : {&smooth, &flat}) {
      const SurfaceDetail seen =
          detail(*geometry, hit_at(0.3F, 0.3F), {0, 0, -1}, 0.01F, {0, 0, 1}, placed);
      expect_near(seen.tangent, {geometry == &flat ? -1 : -along, 0, 0});
      expect_near(seen.bitangent, {0, 1, 0});
    }
  }
}

/// The square bent at x = 1, where u goes back: its halves show the picture and its mirror image,
/// and share the two vertices of the seam.
scene::Mesh mirrored_at_a_seam() {
  scene::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}};
  mesh.normals.assign(6, {0, 0, 1});
  mesh.uvs = {{1, 1}, {0, 1}, {1, 1}, {1, 0}, {0, 0}, {1, 0}};
  mesh.colors.assign(6, {1, 1, 1, 1});
  mesh.triangles = {{1, 4, 0}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
  return mesh;
}

TEST(Details, a_mirrored_seam_parts_its_vertices) {
  const Geometry geometry = merged(shape_of(mirrored_at_a_seam()), flag::tangent | flag::color);
  ASSERT_EQ(geometry.positions.size(), 8U);
  EXPECT_EQ(geometry.colors.size(), 8U);
  EXPECT_EQ(geometry.uvs[0].size(), 8U);
  for (std::uint32_t face = 0; face < 4; ++face) {
    for (const auto& [u, v] : {std::pair{0.01F, 0.01F}, {0.98F, 0.01F}, {0.01F, 0.98F}}) {
      const SurfaceDetail at = detail(geometry, hit_at(u, v, face));
      expect_near(at.tangent, {face < 2 ? -1.0F : 1.0F, 0, 0});
      expect_near(at.bitangent, {0, 1, 0});
    }
  }
}

TEST(Details, a_vertex_whose_faces_disagree_takes_each_faces_tangent) {
  // Two faces about a vertex; on the second u grows the other way.
  scene::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  mesh.normals.assign(5, {0, 0, 1});
  mesh.uvs = {{0, 0}, {1, 0}, {0, -1}, {1, 0}, {0, -1}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 4}};
  const auto tangents = tangents_of(mesh, 0);
  EXPECT_EQ(tangents[0], (std::array<float, 4>{0, 0, 0, 1}));
  const Geometry geometry = merged(shape_of(mesh), flag::tangent);
  EXPECT_EQ(geometry.tangents[0], render::no_tangent);
  expect_near(detail(geometry, hit_at(0, 0, 0)).tangent, {1, 0, 0});
  expect_near(detail(geometry, hit_at(0, 0, 1)).tangent, {-1, 0, 0});
  expect_near(detail(geometry, hit_at(0, 0, 1)).bitangent, {0, -1, 0});
}

TEST(Details, tangents_follow_the_set_that_they_are_asked_for) {
  for (const bool smooth : {false, true}) {
    scene::Mesh mesh = square();
    if (smooth) mesh.normals.assign(4, {0, 0, 1});
    mesh.uvs1 = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};  // u runs up, v to the right
    const Geometry first = merged(shape_of(mesh), flag::uv1 | flag::tangent);
    expect_near(detail(first, hit_at(0.3F, 0.3F)).tangent, {1, 0, 0});
    const std::uint8_t wants = flag::uv1 | flag::tangent | flag::tangent_by_uv1;
    const Geometry second = merged(shape_of(mesh), wants);
    EXPECT_TRUE(second.uvs[0].empty());
    expect_near(detail(second, hit_at(0.3F, 0.3F)).tangent, {0, 1, 0});
    expect_near(detail(second, hit_at(0.3F, 0.3F)).bitangent, {-1, 0, 0});
    mesh.uvs1.clear();
    expect_near(detail(merged(shape_of(mesh), wants), hit_at(0.3F, 0.3F)).tangent, {1, 0, 0});
  }
}

TEST(Details, a_hit_says_what_there_is) {
  scene::Mesh mesh = square();
  mesh.uvs1 = std::move(mesh.uvs);
  mesh.uvs.clear();
  mesh.colors.assign(4, {1, 1, 1, 1});
  const SurfaceDetail second = detail(merged(shape_of(mesh), all), hit_at(0.3F, 0.3F));
  EXPECT_FALSE(second.has_uv(0) || second.has_tangents());
  EXPECT_TRUE(second.has_uv(1));
  mesh.uvs1.clear();
  const SurfaceDetail colored = detail(merged(shape_of(mesh), all), hit_at(0.3F, 0.3F));
  EXPECT_FALSE(colored.has_uv(0) || colored.has_uv(1) || colored.has_tangents());
  mesh.tangents.assign(4, {1, 0, 0, 1});
  const SurfaceDetail given = detail(merged(shape_of(mesh), all), hit_at(0.3F, 0.3F));
  EXPECT_TRUE(given.has_tangents() && !given.has_uv(0));
  const SurfaceDetail quad =
      detail(merged(shape_of(scene::Quad{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), all), hit_at(0, 0));
  EXPECT_TRUE(quad.has_uv(0) && quad.has_uv(1) && quad.has_tangents());
}

TEST(Details, given_tangents_are_taken) {
  scene::Mesh mesh = square();
  mesh.tangents.assign(4, {0, 1, 0, -1});
  const Geometry geometry = merged(shape_of(mesh), flag::tangent);
  expect_near(detail(geometry, hit_at(0.3F, 0.3F)).tangent, {0, 1, 0});
  expect_near(detail(geometry, hit_at(0.3F, 0.3F)).bitangent, {1, 0, 0});
}

TEST(Details, colours_are_interpolated_and_clipped) {
  scene::Mesh mesh = square();
  mesh.colors = {{0, 0, 0, 1}, {1, 0.5F, 0, 1}, {1, 1, 7, 0}, {0, 0, 0, 0}};
  const SurfaceDetail at = detail(merged(shape_of(mesh), flag::color), hit_at(0.5F, 0.5F));
  EXPECT_NEAR(at.color.r, 1, 1e-4);
  EXPECT_NEAR(at.color.g, 0.75F, 1e-4);
  EXPECT_NEAR(at.color.b, 0.5F, 1e-4);
  EXPECT_NEAR(at.alpha, 0.5F, 1e-4);
}

TEST(Details, quads_show_the_picture_upright_also_when_mirrored) {
  const scene::Quad quad{{0, 0, 0}, {2, 0, 0}, {0, 4, 0}};
  const Geometry geometry = merged(shape_of(quad), all);
  for (const auto& [u, v] : {std::pair{0.25F, 0.25F}, {0.75F, 0.75F}}) {
    const render::Vec2 uv = render::uv_at(geometry, hit_at(u, v), 0);
    EXPECT_FLOAT_EQ(uv.x, u);
    EXPECT_FLOAT_EQ(uv.y, 1 - v);
  }
  const scene::Transform mirror{{-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
  const Geometry turned = merged(shape_of(quad), all, mirror);
  // Its corners go around the other way: the hit's u runs along edge_v.
  const render::Vec2 uv = render::uv_at(turned, hit_at(0.25F, 0.125F), 0);
  EXPECT_FLOAT_EQ(uv.x, 0.125F);
  EXPECT_FLOAT_EQ(uv.y, 0.75F);
}

TEST(Details, each_face_of_a_box_shows_the_whole_picture_unmirrored) {
  const Geometry box = merged(shape_of(scene::Box{{0, 0, 0}, {1, 2, 3}}), all);
  const Vec3 normals[] = {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Vec3 tops[] = {{0, 1, 0}, {0, 0, 1}, {0, 1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 1, 0}};
  for (std::uint32_t face = 0; face < 6; ++face) {
    const SurfaceDetail at =
        detail(box, hit_at(0.3F, 0.4F, face), -normals[face], 0.01F, normals[face]);
    expect_near(at.bitangent, tops[face]);
    expect_near(at.tangent, render::cross(tops[face], normals[face]));
  }
}

TEST(Details, a_sphere_is_a_globe) {
  const Geometry globe = merged(shape_of(scene::Sphere{{1, 2, 3}, 2}), all);
  const auto at = [&](const Vec3& n) {
    accel::Hit hit = hit_at(0, 0);
    hit.ng = {n.x, n.y, n.z};
    return detail(globe, hit, -n, 0.01F, n);
  };
  const SurfaceDetail front = at({0, 0, 1});
  EXPECT_NEAR(front.uv[0].uv.x, 0.5F, 1e-6);
  EXPECT_NEAR(front.uv[0].uv.y, 0.5F, 1e-6);
  expect_near(front.tangent, {1, 0, 0});
  expect_near(front.bitangent, {0, 1, 0});
  EXPECT_NEAR(length(front.uv[0].across) + length(front.uv[0].along),
              0.005F * (0.5F + 1) / 3.14159265F, 1e-6);
  EXPECT_NEAR(at({1, 0, 0}).uv[0].uv.x, 0.75F, 1e-6);
  EXPECT_NEAR(at({0, 1, 0}).uv[0].uv.y, 0, 1e-6);
  EXPECT_TRUE(std::isfinite(at({0, 1, 0}).uv[0].along.x));
}

TEST(Tangents, are_smooth_over_a_curved_mesh_and_weighed_by_angle) {
  scene::Mesh mesh;  // a quarter of a cylinder about y; u goes around
  for (int i = 0; i <= 8; ++i) {
    const float a = static_cast<float>(i) * 0.19634954F;
    for (const float y : {0.0F, 1.0F}) {
      mesh.positions.push_back({std::sin(a), y, std::cos(a)});
      mesh.normals.push_back({std::sin(a), 0, std::cos(a)});
      mesh.uvs.push_back({a, 1 - y});
    }
  }
  for (std::uint32_t i = 0; i < 16; i += 2) {
    mesh.triangles.push_back({i, i + 2, i + 1});
    mesh.triangles.push_back({i + 1, i + 2, i + 3});
  }
  const auto tangents = tangents_of(mesh, 0);
  for (std::size_t i = 0; i < tangents.size(); ++i) {
    EXPECT_NEAR(tangents[i][0], mesh.normals[i][2], 1e-5);
    EXPECT_NEAR(tangents[i][1], 0, 1e-5);
    EXPECT_NEAR(tangents[i][2], -mesh.normals[i][0], 1e-5);
    EXPECT_EQ(tangents[i][3], 1);
  }
}

}  // namespace
}  // namespace tessera::worker
