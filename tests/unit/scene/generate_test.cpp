#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "common/base/digest.hpp"
#include "scenes/generate/asteroid.hpp"
#include "scenes/generate/forest.hpp"
#include "scenes/generate/lake.hpp"
#include "scenes/generate/pot.hpp"
#include "scenes/generate/pottery.hpp"
#include "tests/unit/scene/support.hpp"

namespace tessera::generate {
namespace {

TEST(Asteroid, is_a_scene_of_at_least_the_triangles_asked_for_all_different) {
  const TemporaryFolder folder;
  write_asteroid(folder.path() / "new", 5000);
  const scene::LoadedScene loaded = scene::load_scene(folder.path() / "new" / "asteroid.json");
  ASSERT_EQ(loaded.files.size(), 2U);
  const auto& mesh = std::get<scene::Mesh>(loaded.scene.shapes.at(0).geometry);
  EXPECT_GE(mesh.triangles.size(), 5000U);
  std::set<std::array<std::array<float, 3>, 3>> shapes;
  for (const auto& t : mesh.triangles)
    shapes.insert({mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]});
  EXPECT_EQ(shapes.size(), mesh.triangles.size());
}

TEST(Asteroid, is_the_same_bytes_every_time) {
  const TemporaryFolder folder;
  write_asteroid(folder.path() / "a", 1200);
  write_asteroid(folder.path() / "b", 1200);
  EXPECT_EQ(digest_of_file(folder.path() / "a" / "asteroid.obj"),
            digest_of_file(folder.path() / "b" / "asteroid.obj"));
}

TEST(Asteroid, is_turned_outwards_and_closed_at_the_cubes_edges) {
  const TemporaryFolder folder;
  write_asteroid(folder.path(), 3000);
  const scene::LoadedScene loaded = scene::load_scene(folder.path() / "asteroid.json");
  const auto& mesh = std::get<scene::Mesh>(loaded.scene.shapes.at(0).geometry);
  std::multiset<std::array<std::array<float, 3>, 2>> edges;
  for (const auto& t : mesh.triangles) {
    std::array<std::array<float, 3>, 3> p{mesh.positions[t[0]], mesh.positions[t[1]],
                                          mesh.positions[t[2]]};
    for (std::size_t i = 0; i < 3; ++i) edges.insert({p[i], p[(i + 1) % 3]});
  }
  for (const auto& edge : edges) {
    EXPECT_EQ(edges.count(edge), 1U);
    EXPECT_EQ(edges.count({edge[1], edge[0]}), 1U);  // the neighbour runs along it the other way
  }
}

TEST(Lake, has_as_many_lanterns_as_asked_for_none_alike_all_above_the_water) {
  const TemporaryFolder folder;
  write_lake(folder.path(), 400);
  const scene::Scene scene = scene::load_scene(folder.path() / "lake.json").scene;
  std::set<std::array<double, 3>> places;
  for (const scene::Shape& shape : scene.shapes) {
    const auto* lantern = std::get_if<scene::Sphere>(&shape.geometry);
    if (lantern == nullptr) continue;
    places.insert(lantern->center);
    EXPECT_GT(lantern->center[1], 0);
  }
  EXPECT_EQ(places.size(), 400U);
}

TEST(Noise, is_continuous_and_bounded) {
  for (int i = 0; i < 2000; ++i) {
    const Point p{i * 0.37 - 300, i * 0.11, -i * 0.29};
    const double here = noise(p);
    EXPECT_LE(std::abs(here), 1);
    EXPECT_NEAR(noise({p[0] + 1e-7, p[1], p[2]}), here, 1e-5);
  }
}

TEST(Forest, has_at_least_the_trees_asked_for_each_of_which_stands_at_many_places_on_the_ground) {
  const TemporaryFolder folder;
  write_forest(folder.path() / "new", 4000);
  const scene::LoadedScene loaded = scene::load_scene(folder.path() / "new" / "forest.json");
  ASSERT_EQ(loaded.files.size(), 3U);
  EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings.front();
  EXPECT_EQ(loaded.scene.objects.size(), forest_kinds);
  EXPECT_GE(loaded.scene.instances.size(), 4000U);
  std::vector<int> of_kind(forest_kinds);
  for (const scene::Instance& instance : loaded.scene.instances) {
    ++of_kind[instance.object];
    const auto& m = instance.to_world.m;
    EXPECT_NEAR(m[7], ground_height(m[3], m[11]), 1e-3);
  }
  for (const int places : of_kind) EXPECT_GT(places, 20);
}

TEST(Forest, is_the_same_bytes_every_time) {
  const TemporaryFolder folder;
  for (const char* name : {"a", "b"}) write_forest(folder.path() / name, 300);
  for (const char* file : {"forest.json", "forest.gltf", "forest.bin"})
    EXPECT_EQ(digest_of_file(folder.path() / "a" / file),
              digest_of_file(folder.path() / "b" / file));
}

TEST(Pottery, has_at_least_the_triangles_asked_for_and_three_pictures_of_its_own_for_each_pot) {
  const TemporaryFolder folder;
  write_pottery(folder.path() / "new", 20'000);
  const scene::LoadedScene loaded = scene::load_scene(folder.path() / "new" / "pottery.glb");
  EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings.front();
  EXPECT_EQ(loaded.scene.images.size(), 3U * pot_kinds);
  std::size_t triangles = 0;
  std::set<std::uint32_t> materials;
  for (const scene::Shape& shape : loaded.scene.shapes) {
    const auto& mesh = std::get<scene::Mesh>(shape.geometry);
    if (mesh.uvs.empty()) continue;  // the room
    triangles += mesh.triangles.size();
    materials.insert(shape.material);
  }
  EXPECT_GE(triangles, 20'000U);
  EXPECT_EQ(materials.size(), std::size_t{pot_kinds});
}

TEST(Pottery, normals_lead_outwards_and_tangents_follow_u_at_right_angles) {
  const Pot one = pot(3, 60, 30);
  const auto dot = [](const auto& a, const auto& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  };
  for (std::size_t i = 0; i < one.normals.size(); ++i) {
    const auto &n = one.normals[i], &p = one.positions[i];
    const auto& t = one.tangents[i];
    EXPECT_NEAR(dot(n, n), 1, 1e-5);
    EXPECT_NEAR(dot(n, t), 0, 1e-5);
    EXPECT_EQ(t[3], 1);
    const bool outer_wall = one.uvs[i][1] > 0.6F;
    if (outer_wall) {
      EXPECT_GT(n[0] * p[0] + n[2] * p[2], 0);
    }
    if (i == 0 || one.uvs[i - 1][1] != one.uvs[i][1]) continue;
    const auto& before = one.positions[i - 1];  // further along u
    const std::array<float, 3> way{before[0] - p[0], before[1] - p[1], before[2] - p[2]};
    EXPECT_GT(dot(way, t), 0);
  }
}

TEST(Pottery, on_circle_is_cosine_and_sine) {
  for (int i = -40; i < 80; ++i) {
    const double turns = i / 37.0, angle = 2 * M_PI * turns;
    EXPECT_NEAR(on_circle(turns)[0], std::cos(angle), 1e-14);
    EXPECT_NEAR(on_circle(turns)[1], std::sin(angle), 1e-14);
  }
}

TEST(Asteroid, the_grid_is_the_smallest_that_has_enough) {
  EXPECT_EQ(grid_side(12), 1U);
  EXPECT_EQ(grid_side(13), 2U);
  EXPECT_EQ(grid_side(1'200'000), 317U);
}

}  // namespace
}  // namespace tessera::generate
