#include "worker/scene/build.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/error.hpp"
#include "worker/render/interaction.hpp"

namespace tessera::worker {
namespace {

using render::GeometryKind;
using render::Vec3;

scene::Mesh one_triangle(bool smooth) {
  scene::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  if (smooth) mesh.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  return mesh;
}

template <class Geometry>
scene::Shape shape_of(Geometry geometry, std::uint32_t material,
                      const scene::Transform& to_world = {}) {
  return {"shape", std::move(geometry), material, to_world};
}

scene::Transform moved(double x, double y, double z) {
  return {{1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z}};
}
const scene::Transform mirrored{{-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
const scene::Transform squeezed{{1, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1, 0}};

/// Materials 0 and 1 are diffuse, 2 emits.
scene::Scene empty_scene() {
  scene::Scene scene;
  scene.cameras.emplace_back();
  scene.materials = {{"a", scene::Diffuse{{0.1, 0.1, 0.1}}},
                     {"b", scene::Diffuse{{0.2, 0.2, 0.2}}},
                     {"glow", scene::Emitter{{3, 2, 1}, false}}};
  return scene;
}

render::Scene built(scene::Scene scene) { return build_scene(std::move(scene), accel::Device()); }

render::Interaction looked_at(const render::Scene& scene, const Vec3& origin,
                              const Vec3& direction) {
  render::Ray ray;
  ray.origin = origin;
  ray.direction = direction;
  const accel::Hit hit = scene.intersect(ray);
  EXPECT_TRUE(hit.any());
  return hit.any() ? surface_at(scene, ray, hit) : render::Interaction{};
}

TEST(Build, MeshesOfLikeFlagsBecomeOneGeometry) {
  scene::Scene scene = empty_scene();
  for (int i = 0; i < 5; ++i)
    scene.shapes.push_back(shape_of(one_triangle(false), 0, moved(2 * i, 0, 0)));
  for (int i = 0; i < 3; ++i)
    scene.shapes.push_back(shape_of(one_triangle(true), 1, moved(2 * i, 3, 0)));
  scene.shapes.push_back(shape_of(one_triangle(false), 2, moved(0, 6, 0)));
  scene.shapes.push_back(shape_of(scene::Quad{}, 0, moved(0, 9, 0)));
  scene.shapes.push_back(shape_of(scene::Box{}, 1, moved(0, 12, 0)));
  const render::Scene out = built(std::move(scene));
  ASSERT_EQ(out.groups.size(), 1U);
  const auto& geometries = out.groups[0].geometries;
  ASSERT_EQ(geometries.size(), 4U);
  EXPECT_EQ(geometries[0].faces(), 5U);
  EXPECT_TRUE(geometries[0].normals.empty());
  EXPECT_EQ(geometries[1].faces(), 3U);
  EXPECT_EQ(geometries[1].normals.size(), 9U);
  EXPECT_EQ(geometries[2].emitters.size(), 1U);
  EXPECT_EQ(geometries[3].kind, GeometryKind::quads);
  EXPECT_EQ(geometries[3].faces(), 7U);
  EXPECT_EQ(out.lights.size(), 1U);
}

TEST(Build, EveryFaceKeepsItsMaterialAndPlace) {
  scene::Scene scene = empty_scene();
  scene.shapes.push_back(shape_of(one_triangle(false), 0, moved(0, 0, 0)));
  scene.shapes.push_back(shape_of(one_triangle(false), 1, moved(10, 0, 0)));
  scene.shapes.push_back(shape_of(scene::Quad{}, 1, moved(20, 0, 0)));
  scene.shapes.push_back(shape_of(scene::Sphere{}, 0, moved(30, 0, 0)));
  const render::Scene out = built(std::move(scene));
  const struct {
    float x;
    std::uint16_t material;
    float t;
  } cases[] = {{0.2F, 0, 5}, {10.2F, 1, 5}, {20.2F, 1, 5}, {30, 0, 4}};
  for (const auto& one : cases) {
    const render::Interaction at = looked_at(out, {one.x, 0, 5}, {0, 0, -1});
    EXPECT_EQ(at.material, one.material) << one.x;
    EXPECT_FLOAT_EQ(at.t, one.t) << one.x;
    EXPECT_NEAR(at.p.x, one.x, 1e-5);
    EXPECT_FLOAT_EQ(at.shading.normal.z, 1) << one.x;
  }
}

TEST(Build, TheOuterSideStaysOutsideUnderMirrors) {
  for (const bool instanced : {false, true}) {
    scene::Scene scene = empty_scene();
    scene::Object object{
        "thing",
        {shape_of(one_triangle(true), 0), shape_of(scene::Quad{}, 0, moved(3, 0, 0)),
         shape_of(scene::Box{{6, 0, 0}, {7, 1, 1}}, 0),
         shape_of(scene::Sphere{{10, 0.5, 0}, 1}, 0)}};
    scene.objects = {object};
    scene.instances = {{0, mirrored}};
    if (instanced) scene.instances.push_back({0, moved(0, 100, 0)});
    const render::Scene out = built(std::move(scene));
    EXPECT_EQ(out.placements.size(), instanced ? 3U : 1U);
    for (const float x : {-0.2F, -3.5F, -6.5F, -10.0F}) {
      const render::Interaction at = looked_at(out, {x, 0.4F, 5}, {0, 0, -1});
      EXPECT_GT(at.shading.normal.z, 0.9F) << x;
      EXPECT_GT(at.shading.shading.n.z, 0.9F) << x;
    }
  }
}

TEST(Build, AnObjectPlacedOnceIsBakedAndOneNeverPlacedIsLeftOut) {
  scene::Scene scene = empty_scene();
  scene.objects = {{"once", {shape_of(one_triangle(false), 0)}},
                   {"never", {shape_of(one_triangle(false), 0)}},
                   {"thrice", {shape_of(one_triangle(false), 1)}}};
  scene.instances = {
      {0, moved(0, 0, 0)}, {2, moved(5, 0, 0)}, {2, moved(10, 0, 0)}, {2, moved(15, 0, 0)}};
  const render::Scene out = built(std::move(scene));
  EXPECT_EQ(out.groups.size(), 2U);
  EXPECT_EQ(out.placements.size(), 4U);
  EXPECT_EQ(looked_at(out, {0.2F, 0.2F, 1}, {0, 0, -1}).placement, 0U);
  EXPECT_EQ(looked_at(out, {5.2F, 0.2F, 1}, {0, 0, -1}).placement, 1U);
  const render::Interaction last = looked_at(out, {15.2F, 0.2F, 1}, {0, 0, -1});
  EXPECT_EQ(last.placement, 3U);
  EXPECT_EQ(last.material, 1U);
  EXPECT_NEAR(last.p.x, 15.2F, 1e-5);
}

TEST(Build, ASqueezedSphereIsAnEllipsoid) {
  scene::Scene scene = empty_scene();
  scene.shapes.push_back(shape_of(scene::Sphere{{0, 0, 0}, 2}, 1, squeezed));
  scene.objects = {{"two", {shape_of(scene::Sphere{{0, 0, 0}, 2}, 0, squeezed)}}};
  scene.instances = {{0, moved(10, 0, 0)}, {0, moved(20, 0, 0)}};
  const render::Scene out = built(std::move(scene));
  for (const float x : {0.0F, 10.0F, 20.0F}) {
    EXPECT_FLOAT_EQ(looked_at(out, {x, 5, 0}, {0, -1, 0}).t, 4);
    EXPECT_FLOAT_EQ(looked_at(out, {x, 0, 5}, {0, 0, -1}).t, 3);
    // On the flank the normal leans towards the squeezed axis.
    const render::Interaction flank = looked_at(out, {x + 1.4142135F, 5, 0}, {0, -1, 0});
    EXPECT_NEAR(flank.shading.normal.y / flank.shading.normal.x, 2, 1e-3);
  }
}

TEST(Build, EveryFaceThatEmitsIsALight) {
  scene::Scene scene = empty_scene();
  scene.shapes.push_back(shape_of(scene::Box{}, 2));
  scene.shapes.push_back(shape_of(scene::Sphere{}, 2, moved(5, 0, 0)));
  scene.objects = {{"lamp", {shape_of(one_triangle(false), 2), shape_of(scene::Quad{}, 0)}}};
  scene.instances = {{0, moved(10, 0, 0)}, {0, moved(20, 0, 0)}};
  scene.environment = scene::Environment{{1, 1, 1}};
  const render::Scene out = built(std::move(scene));
  ASSERT_EQ(out.lights.size(), 6U + 1U + 2U + 1U);
  EXPECT_EQ(out.lights.seen_far(), std::vector<std::uint32_t>(1, 9U));
  EXPECT_EQ(out.light_errors.size(), 10U);
  // What a ray meets is the light that was sampled there.
  const render::Interaction sphere = looked_at(out, {5, 0, 5}, {0, 0, -1});
  ASSERT_NE(sphere.light, render::no_id);
  EXPECT_TRUE(std::holds_alternative<render::SphereLight>(out.lights[sphere.light].shape));
  const render::Light& last = out.lights[8];
  const auto& triangle = std::get<render::TriangleLight>(last.shape);
  EXPECT_FLOAT_EQ(triangle.a.x, 20);
  EXPECT_FLOAT_EQ(last.radiance.r, 3);
  for (const auto& corner : {Vec3{0.5F, 0.5F, 5}, Vec3{0.5F, 5, 0.5F}, Vec3{-5, 0.5F, 0.5F}}) {
    const Vec3 to = render::normalize(Vec3{0.5F, 0.5F, 0.5F} - corner);
    const render::Interaction at = looked_at(out, corner, to);
    ASSERT_NE(at.light, render::no_id);
    const auto& quad = std::get<render::QuadLight>(out.lights[at.light].shape);
    const Vec3 n = render::normalize(render::cross(quad.edge_u, quad.edge_v));
    EXPECT_GT(render::dot(n, at.shading.normal), 0.999F);
  }
}

TEST(Build, AMirroredInstancesLampShinesOutwards) {
  scene::Scene scene = empty_scene();
  scene.objects = {
      {"lamp", {shape_of(one_triangle(false), 2), shape_of(scene::Quad{{3, 0, 0}}, 2)}}};
  scene.instances = {{0, mirrored}, {0, moved(20, 0, 0)}};
  const render::Scene out = built(std::move(scene));
  for (const float x : {-0.2F, -3.5F, 20.2F, 23.5F}) {
    const render::Interaction at = looked_at(out, {x, 0.2F, 3}, {0, 0, -1});
    ASSERT_NE(at.light, render::no_id);
    render::LightContext context;
    context.p = {x, 0.2F, 3};
    const render::Color seen = render::emitted(out.lights[at.light], context, {0, 0, -1});
    EXPECT_FLOAT_EQ(seen.r, 3) << x;
  }
}

TEST(Build, AnEmittingEllipsoidIsAnError) {
  scene::Scene scene = empty_scene();
  scene.shapes.push_back(shape_of(scene::Sphere{}, 2, squeezed));
  try {
    built(std::move(scene));
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::bad_input);
    EXPECT_NE(error.message().find("ellipsoid"), std::string::npos);
  }
}

TEST(Build, AFlatInstanceIsAnError) {
  scene::Scene scene = empty_scene();
  scene.objects = {{"thing", {shape_of(one_triangle(false), 0)}}};
  scene.instances = {{0, {{1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0}}}, {0, {}}};
  EXPECT_THROW(built(std::move(scene)), Error);
}

TEST(Build, AFarSceneIsMovedToWhereFloatIsFine) {
  scene::Scene scene = empty_scene();
  scene.shapes.push_back(shape_of(scene::Sphere{}, 0, moved(1e8, 0, 0)));
  const render::Scene out = built(std::move(scene));
  EXPECT_DOUBLE_EQ(out.origin[0], 1e8);
  EXPECT_FLOAT_EQ(looked_at(out, {0, 0, 5}, {0, 0, -1}).t, 4);
  scene::Scene near = empty_scene();
  near.shapes.push_back(shape_of(scene::Sphere{}, 0, moved(3, 0, 0)));
  EXPECT_EQ(built(std::move(near)).origin, (std::array<double, 3>{}));
}

TEST(Build, AnObjectFarFromItsOwnOriginIsMovedToWhereFloatIsFine) {
  scene::Scene scene = empty_scene();
  // A float's step is 64 there.
  scene.objects = {{"far", {shape_of(scene::Sphere{{1e9, 3, -2e9}, 0.75}, 0)}}};
  const scene::Transform half_turned{{0, -2, 0, 6, 2, 0, 0, 11 - 2e9, 0, 0, 2, 4e9}};
  scene.instances = {{0, moved(-1e9, -3, 2e9)}, {0, half_turned}};
  const render::Scene out = built(std::move(scene));
  ASSERT_EQ(out.groups.size(), 2U);
  const accel::Sphere& kept = out.groups[1].geometries[0].spheres[0];
  for (const float x : kept.center) EXPECT_EQ(x, 0);
  const render::Interaction first = looked_at(out, {0.25F, 0, 9}, {0, 0, -1});
  EXPECT_NEAR(first.p.z, std::sqrt(0.5), 1e-6);
  EXPECT_LT(first.error, 1e-5);
  const render::Interaction second = looked_at(out, {0, 11, 9}, {0, 0, -1});
  EXPECT_NEAR(second.p.z, 1.5, 1e-6);
}

TEST(Build, ASceneOfNothingShowsItsEnvironment) {
  scene::Scene scene = empty_scene();
  scene.environment = scene::Environment{{2, 2, 2}};
  const render::Scene out = built(std::move(scene));
  render::Ray ray;
  EXPECT_FALSE(out.intersect(ray).any());
  EXPECT_EQ(out.lights.size(), 1U);
}

}  // namespace
}  // namespace tessera::worker
