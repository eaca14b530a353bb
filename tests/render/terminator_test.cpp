#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ostream>
#include <string>

#include "tests/render/support.hpp"

/// Where a sun grazes a smooth mesh of few faces, it is lit as the round thing that it stands for.
namespace tessera::render::proof {
namespace {

constexpr double albedo = 0.5;
constexpr int bounces_enough = 64;

/// How a ball comes to stand in the world: baked into it, or as one of two instances, by transforms
/// that together leave it a ball of radius 1 about the origin.
struct Stand {
  const char* name;
  bool instanced = false;
  scene::Transform in_object = {}, in_world = {};
  bool stretched = false;  ///< in its object
};
void PrintTo(const Stand& stand, std::ostream* out) { *out << stand.name; }

const scene::Transform mirror_x = scale(-1, 1, 1), turn = rotate({3, -1, 2}, 71);
const Stand baked{.name = "Baked"};
const std::array<Stand, 7> stands{
    {baked,
     {.name = "Instanced", .instanced = true},
     {.name = "ScaledInstance",
      .instanced = true,
      .in_object = scale(40, 40, 40),
      .in_world = scale(0.025, 0.025, 0.025)},
     {.name = "TurnedInstance", .instanced = true, .in_object = {}, .in_world = turn},
     {.name = "MirroredInstance", .instanced = true, .in_object = {}, .in_world = mirror_x},
     {.name = "MirroredInObjectAndWorld",
      .instanced = true,
      .in_object = mirror_x,
      .in_world = scale(1, 1, -1)},
     {.name = "StretchedMirroredTurnedInstance",
      .instanced = true,
      .in_object = scale(1.25, 0.8, 1) * turn,
      .in_world = turn * mirror_x * scale(0.8, 1.25, 1),
      .stretched = true}}};

/// Adds a mesh that stands so. The other instance is out of the way of camera and light.
void add_stood(SceneMaker& maker, std::uint32_t material, const scene::Mesh& mesh,
               const Stand& stand) {
  if (!stand.instanced) {
    maker.add(material, mesh, stand.in_world * stand.in_object);
    return;
  }
  scene::Scene& scene = maker.description;
  scene.objects.push_back({"stood", {}});
  scene.objects.back().shapes.push_back({"mesh", mesh, material, stand.in_object});
  const auto object = static_cast<std::uint32_t>(scene.objects.size() - 1);
  scene.instances.push_back({object, stand.in_world});
  scene.instances.push_back({object, translate(0, -50, 0) * stand.in_world});
}

/// A ball of 128 faces, seen from so far that rays are all but parallel, its film from −1 to 1. It
/// is turned so that no row of edges runs where a sun along an axis grazes it.
SceneMaker coarse_ball(double reflectance, Stand stand) {
  SceneMaker maker;
  stand.in_object = stand.in_object * rotate({1, 2, 0.5}, 33);
  add_stood(maker, maker.diffuse(reflectance), ball(2, true), stand);
  constexpr double away = 1000;
  maker.look({0, 0, away}, {0, 0, 0}, 2 * std::atan(1 / away) * 180 / pi_d, {0, 1, 0});
  return maker;
}

SceneMaker sunlit(const Stand& stand, double angle = 0) {
  SceneMaker maker = coarse_ball(albedo, stand);
  maker.description.lights.push_back(
      {.name = "sun",
       .shape = scene::DirectionalLight{
           .direction = {-1, 0, 0}, .irradiance = {1, 1, 1}, .angle_degrees = angle}});
  return maker;
}

class Terminator : public testing::TestWithParam<Stand> {};
INSTANTIATE_TEST_SUITE_P(Of, Terminator, testing::ValuesIn(stands),
                         [](const auto& test) { return std::string(test.param.name); });

/// Where `column` of a film from −1 to 1 has its middle.
double middle(int column, int side) { return 2 * (column + 0.5) / side - 1; }

TEST_P(Terminator, ACoarseBallIsLitAsASphereIs) {
  constexpr int side = 64;
  const RenderedTask done = render(sunlit(GetParam()).build(), {.side = side, .samples = 16}, 1);
  const auto light = done.image.plane(image::R);
  double most = 0;
  for (int y = 0; y < side; ++y) {
    double before = 0;
    for (int x = 0; x < side; ++x) {
      const double at_x = middle(x, side), at_y = middle(y, side);
      if (at_x * at_x + at_y * at_y > 0.8 * 0.8) continue;  // the mesh's own outline
      const double found = double{light[static_cast<std::size_t>(y * side + x)]} * pi_d / albedo;
      most = std::max(most, std::abs(found - std::max(0.0, at_x)));
      // Across the terminator and its faces' edges it never darkens towards the sun.
      EXPECT_GT(found, before - 0.004) << x << ' ' << y;
      before = found;
    }
  }
  // Its faces lie within the sphere by a thirtieth; where faces hide themselves it is .086.
  EXPECT_LT(most, 0.05);
}

TEST_P(Terminator, AllIntegratorsSeeTheSame) {
  const Scene scene = sunlit(GetParam(), 20).build();
  const Take take{.side = 8, .samples = 256};
  const Estimate by_path = measure(scene, take, 16);
  EXPECT_LT(by_path.error, 0.003 * by_path.mean);
  for (const char* integrator : {"cosine", "hemisphere", "hemisphere_lights"}) {
    Take other = take;
    other.integrator = integrator;
    other.samples = 512;
    const Estimate found = measure(scene, other, 16);
    const double error = std::sqrt(found.error * found.error + by_path.error * by_path.error);
    EXPECT_LT(error, 0.015 * by_path.mean) << integrator;
    EXPECT_NEAR(found.mean, by_path.mean, student_bound(30) * error) << integrator;
  }
}

TEST_P(Terminator, AWhiteBallInAFurnaceIsNotThere) {
  SceneMaker maker = coarse_ball(1, GetParam());
  maker.environment(0.75);
  expect_mean(measure(maker.build(), {.side = 16, .samples = 64, .bounces = bounces_enough}, 16),
              0.75, 0.001);
}

TEST_P(Terminator, AnotherSizeOfAPowerOfTwoHasTheSameBits) {
  const auto picture = [](double factor) {
    SceneMaker maker = sunlit(GetParam());
    maker.scaled(factor, {0, 0, 0});
    return render(maker.build(), {.side = 32, .samples = 4}, 1).image;
  };
  const image::TileImage one = picture(1);
  for (const double factor : {0x1p-10, 0x1p10}) {
    const image::TileImage other = picture(factor);
    EXPECT_TRUE(std::ranges::equal(one.plane(image::R), other.plane(image::R))) << factor;
  }
}

TEST_P(Terminator, NoLightComesIntoASmoothBall) {
  SceneMaker maker;
  Stand stand = GetParam();
  stand.in_object = stand.in_object * rotate({1, 2, 0.5}, 33);
  add_stood(maker, maker.diffuse(0.9), ball(1, true), stand);
  maker.environment(1000).look({0, 0, 0.1}, {0.3, 0.2, -1}, 90);
  const RenderedTask done = render(maker.build(), {32, 64, 16}, 7);
  double sum = 0;
  for (const float value : done.image.plane(image::R)) sum += double{value};
  EXPECT_LT(sum / static_cast<double>(done.image.pixels()), 1000 * 1e-6);
}

scene::Vec3 directed(const scene::Transform& t, const scene::Vec3& v) {
  const auto row = [&](std::size_t at) {
    return t.m[at] * v[0] + t.m[at + 1] * v[1] + t.m[at + 2] * v[2];
  };
  return {row(0), row(4), row(8)};
}

TEST_P(Terminator, AFlatFaceWhoseNormalsAllTiltAlikeKeepsItsHorizon) {
  SceneMaker maker;
  scene::Mesh mesh;
  mesh.positions = {{-1, 0, -1}, {0, 0, 2}, {1, 0, -1}};
  mesh.triangles = {{0, 1, 2}};
  mesh.normals.assign(3, {0.6F, 0.8F, 0});
  add_stood(maker, maker.diffuse(albedo), mesh, GetParam());
  // Camera and sun stand to the face as they do where it is baked and not turned.
  const scene::Transform moved = GetParam().in_world * GetParam().in_object;
  maker.look(directed(moved, {0, 3, 0}), {0, 0, 0}, 0.001, directed(moved, {0, 0, -1}));
  scene::DirectionalLight sun{.direction = directed(moved, {-5, 1, 0}), .irradiance = {1, 1, 1}};
  maker.description.lights.push_back({.name = "sun", .shape = sun});
  EXPECT_EQ(measure(maker.build(), {4, 16}, 2).mean, 0);
  // From above the horizon it does light the face.
  sun.direction = directed(moved, {-5, -1, 0});
  maker.description.lights[0].shape = sun;
  EXPECT_GT(measure(maker.build(), {4, 16}, 2).mean, 0.1 * albedo / pi_d);
}

TEST(TerminatorOf, AnInstanceIsLitAsItsMeshInTheWorldIs) {
  constexpr int side = 64;
  for (const Stand& stand : stands) {
    if (!stand.instanced) continue;
    Stand in_world = stand;
    in_world.instanced = false;
    const Take take{.side = side, .samples = 16};
    const image::TileImage found = render(sunlit(stand).build(), take, 1).image,
                           expected = render(sunlit(in_world).build(), take, 1).image;
    const auto one = found.plane(image::R), other = expected.plane(image::R);
    std::size_t apart = 0;
    double sum = 0;
    for (std::size_t i = 0; i < one.size(); ++i) {
      const double difference = std::abs(double{one[i]} - double{other[i]});
      apart += difference > 1e-4 ? 1 : 0;
      sum += difference;
    }
    // Normals are interpolated in the object's space: where that is stretched, they turn a little
    // from one corner to the next otherwise, in every pixel.
    EXPECT_LT(sum / static_cast<double>(one.size()), stand.stretched ? 5e-4 : 1e-5) << stand.name;
    // Rays that graze an edge may round to its other side.
    if (!stand.stretched) {
      EXPECT_LE(apart, one.size() / 500) << stand.name;
    }
  }
}

}  // namespace
}  // namespace tessera::render::proof
