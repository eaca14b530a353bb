#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/support.hpp"

/// No surface may hide itself, however large, small or far away the scene is.
namespace tessera::render::proof {
namespace {

/// A white convex thing under a constant environment of 1 scatters exactly 1 in every single
/// sample: light and BSDF are sampled alike, and nothing stands in the way but the thing itself.
void expect_no_self_hit(const SceneMaker& maker, const char* what, double factor) {
  const Scene scene = maker.build();
  const RenderedTask done = render(scene, {32, 32, 0}, 5);
  std::size_t hits = 0;
  for (std::size_t i = 0; i < done.image.pixels(); ++i) {
    ASSERT_NEAR(done.image.plane(image::R)[i], 1, 1e-5) << what << " scaled by " << factor;
    ASSERT_LT(done.image.plane(image::M2_R)[i], 1e-7) << what << " scaled by " << factor;
    if (done.image.plane(image::albedo_R)[i] > 0) ++hits;
  }
  EXPECT_GT(hits, 200U) << what;
}

SceneMaker convex(int kind) {
  SceneMaker maker;
  const std::uint32_t white = maker.diffuse(1);
  const scene::Transform turn = rotate({1, 2, 0.5}, 33);
  if (kind == 0) maker.add(white, scene::Sphere{{0, 0, 0}, 1});
  if (kind == 1) maker.add(white, scene::Box{{-1, -1, -1}, {0.7, 1, 0.8}}, turn);
  if (kind == 2) maker.add(white, ball(3, false), turn);
  if (kind == 3) maker.add(white, scene::Sphere{{0.1, 0, 0}, 1}, turn * scale(1, 0.3, 1.2));
  if (kind == 4) {
    scene::Object object;
    object.name = "twice";
    scene::Shape shape;
    shape.geometry = ball(2, false);
    shape.material = white;
    object.shapes = {shape};
    maker.description.objects = {object};
    // The second stands so that no ray from the first meets it: far behind the camera, small.
    maker.description.instances = {{0, turn * scale(1, 0.4, 0.8)},
                                   {0, translate(0, 0, 1e5) * scale(1e-7, 1e-7, 1e-7)}};
  }
  maker.environment(1).look({0, 0.5, 6}, {0, 0, 0}, 25);
  return maker;
}

TEST(Robust, ConvexThingsDoNotHideThemselvesAtAnySize) {
  const char* names[] = {"sphere", "box", "mesh", "ellipsoid", "instance"};
  for (int kind = 0; kind < 5; ++kind) {
    for (const double factor : {1e-8, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9, 1e12}) {
      SceneMaker maker = convex(kind);
      maker.scaled(factor, {0, 0, 0});
      expect_no_self_hit(maker, names[kind], factor);
    }
  }
}

TEST(Robust, ConvexThingsDoNotHideThemselvesFarFromTheOrigin) {
  const char* names[] = {"sphere", "box", "mesh", "ellipsoid", "instance"};
  for (int kind = 0; kind < 5; ++kind) {
    // Within the reach of float's precision, where no origin is subtracted …
    SceneMaker near = convex(kind);
    near.scaled(1, {12, -7, 9});
    expect_no_self_hit(near, names[kind], 1);
    if (kind == 4) continue;  // its second instance makes the scene too wide to be moved
    // … and so far off that it is.
    SceneMaker far = convex(kind);
    far.scaled(1, {3e7, -2e7, 5e7});
    expect_no_self_hit(far, names[kind], 1);
  }
}

/// A ball whose normals are far from those of its few faces.
SceneMaker roughly_round(std::uint32_t material, SceneMaker maker) {
  maker.add(material, ball(1, true), rotate({1, 2, 0.5}, 33));
  maker.environment(1).look({0, 0.5, 6}, {0, 0, 0}, 15);
  return maker;
}

TEST(Robust, ASmoothMirrorOfFewFacesLosesNoLight) {
  SceneMaker maker;
  const std::uint32_t mirror = maker.mirror(1);
  const Scene scene = roughly_round(mirror, std::move(maker)).build();
  const RenderedTask done = render(scene, {.side = 32, .samples = 16, .bounces = 1}, 5);
  for (std::size_t i = 0; i < done.image.pixels(); ++i)
    ASSERT_NEAR(done.image.plane(image::R)[i], 1, 1e-5) << i;
}

TEST(Robust, ASmoothBallOfFewFacesHasNoBlackPatches) {
  SceneMaker maker;
  const std::uint32_t white = maker.diffuse(1);
  const Scene scene = roughly_round(white, std::move(maker)).build();
  const RenderedTask done = render(scene, {.side = 32, .samples = 64}, 5);
  for (std::size_t i = 0; i < done.image.pixels(); ++i)
    ASSERT_GT(done.image.plane(image::R)[i], 0.6) << i;
}

TEST(Robust, ALampJustAboveAFloorIsNotHiddenByItself) {
  // The direct light of a lamp 2×2 one unit up, however the whole is turned, scaled and moved.
  for (const double factor : {1e-5, 1.0, 1e5}) {
    SceneMaker maker;
    const scene::Transform turn = rotate({0.3, 1, 0.7}, 57);
    maker.add(maker.diffuse(0.5), scene::Quad{{-0.5, 0, -0.5}, {0, 0, 1}, {1, 0, 0}}, turn);
    maker.add(maker.emitter(1), scene::Quad{{-1, 1, -1}, {2, 0, 0}, {0, 0, 2}}, turn);
    const auto turned = [&](double x, double y, double z) {
      const auto& m = turn.m;
      return scene::Vec3{m[0] * x + m[1] * y + m[2] * z, m[4] * x + m[5] * y + m[6] * z,
                         m[8] * x + m[9] * y + m[10] * z};
    };
    maker.look(turned(-2, 0.3, 0.1), turned(0, 0, 0));
    maker.scaled(factor, {10 * factor, 20 * factor, -5 * factor});
    expect_mean(measure(maker.build(), {4, 64}), 0.5 * 0.5541264);
  }
}

TEST(Robust, NoLightLeaksIntoAClosedBox) {
  SceneMaker maker;
  maker.add(maker.diffuse(0.9), scene::Box{{-1, -1, -1}, {1, 1, 1}}, rotate({1, 2, 0.5}, 33));
  maker.environment(1000).look({0, 0, 0.1}, {0.3, 0.2, -1}, 90);
  const RenderedTask done = render(maker.build(), {64, 64, 16}, 7);
  double sum = 0;
  for (const float value : done.image.plane(image::R)) sum += value;
  // A sample in a million may slip out where two walls meet.
  EXPECT_LT(sum / static_cast<double>(done.image.pixels()), 1000 * 1e-6);
}

/// A lamp 2×2 above a floor, of two triangles or as a quad, which stands `away` from its object's
/// origin. Instances put it back, one unit and `lift` above the floor.
struct PutBack {
  double away = 0, lift = 0;
  bool of_triangles = false;
  bool anchored = false;  ///< something small of the object is at its origin

  [[nodiscard]] scene::Shape lamp(std::uint32_t material) const {
    const double x = away, y = 1 - 0.7 * away, z = 0.3 * away;
    scene::Shape lamp;
    lamp.material = material;
    lamp.geometry = scene::Quad{{x - 1, y, z - 1}, {2, 0, 0}, {0, 0, 2}};
    if (!of_triangles) return lamp;
    scene::Mesh mesh;
    for (const auto& [u, v] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
      mesh.positions.push_back(
          {static_cast<float>(x + u), static_cast<float>(y), static_cast<float>(z + v)});
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    lamp.geometry = std::move(mesh);
    return lamp;
  }
  /// What the floor sends back.
  [[nodiscard]] Estimate measured() const {
    SceneMaker maker = floor_scene();
    scene::Object object{"lamp", {lamp(maker.emitter(1))}};
    if (anchored) {
      scene::Shape anchor;
      anchor.geometry = scene::Sphere{{0, 0, 0}, 1e-3};
      object.shapes.push_back(std::move(anchor));
    }
    maker.description.objects = {std::move(object)};
    const auto back = [&](double up) { return translate(-away, 0.7 * away + up, -0.3 * away); };
    maker.description.instances = {{0, back(lift)}, {0, back(-9)}};  // one where nobody looks
    const Scene scene = maker.build();
    EXPECT_EQ(scene.lights.size(), 2U);
    return measure(scene, {4, 64});
  }
};

void expect_as_near(const PutBack& far, double precision) {
  PutBack near = far;
  near.away = 0;
  near.anchored = false;
  EXPECT_NEAR(far.measured().mean / near.measured().mean, 1, precision)
      << far.away << " away, lifted by " << far.lift << (far.of_triangles ? ", triangles" : "");
}

TEST(Robust, ALampFarFromItsObjectsOriginIsNotHiddenByItself) {
  for (const bool of_triangles : {false, true})
    for (const double away : {30.0, 1e3, 1e4, 1e5, 1e6})
      for (const double lift : {0.0002, 0.0013, 0.003, 0.02, 0.05})
        expect_as_near({away, lift, of_triangles, false}, 1e-6);
}

TEST(Robust, NorIsOneOfAnObjectThatReachesAsFar) {
  for (const bool of_triangles : {false, true})
    for (const double away : {30.0, 1e3, 1e4, 1e5})
      for (const double lift : {0.0002, 0.0013, 0.003, 0.02, 0.05})
        expect_as_near({away, lift, of_triangles, true}, 1e-3);
}

}  // namespace
}  // namespace tessera::render::proof
