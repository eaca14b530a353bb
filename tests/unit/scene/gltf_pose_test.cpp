#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/scene/gltf/animation.hpp"
#include "tests/unit/scene/gltf_file.hpp"

namespace tessera::scene {
namespace {

using testing::Contains;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;

/// A file with one animation of one channel, and what its node is at any time.
class Animated {
 public:
  Animated(const std::string& path, const std::vector<float>& times,
           const std::vector<float>& values, const std::string& type,
           const std::string& interpolation = "LINEAR") {
    file.with_triangle();
    file.json["animations"] = {
        {{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}}},
         {"samplers",
          {{{"input", file.floats(times, "SCALAR")},
            {"output", file.floats(values, type)},
            {"interpolation", interpolation}}}}}};
  }

  tinygltf::Node at(double time) const {
    const TemporaryFolder folder;
    folder.write("model.glb", file.glb());
    gltf::Asset asset = gltf::read_asset(FolderFiles(folder.path()), "model.glb");
    gltf::Accessors accessors(asset);
    gltf::animate(asset, accessors, time);
    return asset.model.nodes[0];
  }

  GltfFile file;
};

TEST(GltfAnimation, linear_keys_are_joined_by_straight_lines_and_hold_at_the_ends) {
  const Animated one("translation", {1, 2, 4}, {0, 0, 0, 2, 0, 0, 2, 8, 0}, "VEC3");
  EXPECT_THAT(one.at(0).translation, ElementsAre(0, 0, 0));
  EXPECT_THAT(one.at(1.5).translation, ElementsAre(1, 0, 0));
  EXPECT_THAT(one.at(2).translation, ElementsAre(2, 0, 0));
  EXPECT_THAT(one.at(3).translation, ElementsAre(2, 4, 0));
  EXPECT_THAT(one.at(99).translation, ElementsAre(2, 8, 0));
}

TEST(GltfAnimation, steps_hold_until_the_next_key) {
  const Animated one("scale", {0, 1}, {1, 1, 1, 3, 3, 3}, "VEC3", "STEP");
  EXPECT_THAT(one.at(0.999).scale, ElementsAre(1, 1, 1));
  EXPECT_THAT(one.at(1).scale, ElementsAre(3, 3, 3));
}

TEST(GltfAnimation, rotations_turn_at_an_even_pace_the_shorter_way) {
  const auto half = static_cast<float>(std::sqrt(0.5));
  // The second key is the same turn by 90° about y with the other sign.
  const Animated one("rotation", {0, 1}, {0, 0, 0, 1, 0, -half, 0, -half}, "VEC4");
  const std::vector<double> third = one.at(1.0 / 3).rotation;
  EXPECT_NEAR(std::abs(third[1]), std::sin(3.14159265358979 / 12), 1e-7);
  EXPECT_NEAR(std::abs(third[3]), std::cos(3.14159265358979 / 12), 1e-7);
}

TEST(GltfAnimation, cubic_splines_pass_their_keys_with_their_tangents) {
  // From 0 with slope 2 to 1 with slope 0, over 2 seconds; tangents are per second.
  const Animated one("translation", {0, 2}, {9, 9, 9, 0, 0, 0, 2, 0, 0, 0, 0, 0, 1, 0, 0, 9, 9, 9},
                     "VEC3", "CUBICSPLINE");
  EXPECT_THAT(one.at(0).translation[0], DoubleNear(0, 1e-12));
  EXPECT_THAT(one.at(2).translation[0], DoubleNear(1, 1e-12));
  // Hermite at ½: ½·p0 + ⅛·m0 + ½·p1 − ⅛·m1, tangents times the span.
  EXPECT_THAT(one.at(1).translation[0], DoubleNear(0.5 + 4.0 / 8, 1e-12));
  EXPECT_THAT(one.at(1e-4).translation[0], DoubleNear(2e-4, 1e-7));
}

TEST(GltfAnimation, a_scene_is_read_as_it_is_at_a_moment_and_knows_how_long_it_moves) {
  const Animated one("translation", {0, 2}, {0, 0, 0, 8, 0, 0}, "VEC3");
  const TemporaryFolder folder;
  folder.write("model.glb", one.file.glb());
  folder.write("s.json", R"({"tessera": 1, "include": ["model.glb"]})");
  const FolderFiles files(folder.path());
  for (const char* name : {"model.glb", "s.json"}) {
    const LoadedScene begin = load_scene(files, name);
    EXPECT_EQ(begin.duration, 2) << name;
    EXPECT_TRUE(begin.made_up.camera && begin.made_up.light) << name;
    const LoadedScene later = load_scene(files, name, {.time = 1.5, .made_up = begin.made_up});
    EXPECT_EQ(later.duration, 2) << name;
    EXPECT_EQ(later.scene.shapes.at(0).to_world.m[3], 6) << name;
    // What was made up does not run after what moves.
    EXPECT_EQ(later.scene.cameras.at(0).target, begin.scene.cameras.at(0).target) << name;
    EXPECT_EQ(later.scene.environment->rotation_degrees, begin.scene.environment->rotation_degrees);
  }
  EXPECT_EQ(GltfFile().with_triangle().load().duration, 0);
}

TEST(GltfAnimation, a_lamp_that_is_scaled_away_for_a_moment_leaves_the_dark) {
  Animated one("scale", {0, 1}, {1, 1, 1, 0, 0, 0}, "VEC3", "STEP");
  one.file.json["materials"] = nlohmann::json::array({{{"emissiveFactor", {1, 1, 1}}}});
  one.file.json["meshes"][0]["primitives"][0]["material"] = 0;
  const TemporaryFolder folder;
  folder.write("model.glb", one.file.glb());
  const FolderFiles files(folder.path());
  const LoadedScene begin = load_scene(files, "model.glb");
  EXPECT_FALSE(begin.scene.environment);
  EXPECT_FALSE(
      load_scene(files, "model.glb", {.time = 1, .made_up = begin.made_up}).scene.environment);
}

TEST(GltfAnimation, what_does_not_fit_together_is_refused) {
  const auto error_of_one = [](const Animated& one) { return error_of_bytes(one.file.glb()); };
  const Error back = error_of_one(Animated("scale", {1, 1}, {1, 1, 1, 1, 1, 1}, "VEC3"));
  EXPECT_EQ(back.place().key, "/animations/0/samplers/0/input");
  const Error few = error_of_one(Animated("scale", {0, 1}, {1, 1, 1}, "VEC3"));
  EXPECT_EQ(few.place().key, "/animations/0/samplers/0/output");
  Animated none("scale", {0, 1}, {1, 1, 1, 1, 1, 1}, "VEC3");
  none.file.json["animations"][0]["channels"][0]["sampler"] = 3;
  EXPECT_THAT(error_of_one(none).message(), HasSubstr("there is no sampler 3"));
}

TEST(GltfMorph, targets_add_their_parts_by_the_node_s_weights_or_the_mesh_s) {
  GltfFile file;
  file.with_triangle();
  nlohmann::json& mesh = file.json["meshes"][0];
  mesh["primitives"][0]["targets"] = {
      {{"POSITION", file.floats({0, 0, 4, 0, 0, 0, 0, 0, 0}, "VEC3")}},
      {{"POSITION", file.floats({8, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC3")}}};
  mesh["weights"] = {0.5, 0};
  EXPECT_EQ(mesh_of(file.load().scene.shapes.at(0)).positions.at(0),
            (std::array<float, 3>{0, 0, 2}));
  file.json["nodes"][0]["weights"] = {0, 0.25};
  EXPECT_EQ(mesh_of(file.load().scene.shapes.at(0)).positions.at(0),
            (std::array<float, 3>{2, 0, 0}));
  // Two nodes with other weights are two shapes.
  file.node({{"mesh", 0}, {"weights", {1, 0}}});
  EXPECT_EQ(file.load().scene.shapes.size(), 2U);
}

TEST(GltfSkin, vertices_follow_their_joints_and_not_their_node) {
  GltfFile file;
  file.with_triangle();
  nlohmann::json& attributes = file.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["NORMAL"] = file.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  attributes["JOINTS_0"] =
      file.accessor<std::uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, "VEC4", 5121);
  attributes["WEIGHTS_0"] = file.floats({1, 0, 0, 0, 1, 0, 0, 0, .5F, .5F, 0, 0}, "VEC4");
  file.json["nodes"][0]["translation"] = {100, 0, 0};
  file.json["nodes"][0]["skin"] = 0;
  const int still = file.node(nlohmann::json::object());
  const int risen = file.node({{"translation", {0, 0, 6}}});
  // The second joint's bind pose was 1 up: the vertex is that much lower in its space.
  const int inverses = file.floats({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0,  1,
                                    1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -1, 1},
                                   "MAT4");
  file.json["skins"] = {{{"joints", {still, risen}}, {"inverseBindMatrices", inverses}}};
  const LoadedScene loaded = file.load();
  const Mesh& mesh = mesh_of(loaded.scene.shapes.at(0));
  EXPECT_EQ(mesh.positions.at(0), (std::array<float, 3>{0, 0, 0}));
  EXPECT_EQ(mesh.positions.at(1), (std::array<float, 3>{1, 0, 5}));
  EXPECT_EQ(mesh.positions.at(2), (std::array<float, 3>{0, 1, 2.5F}));
  EXPECT_EQ(mesh.normals.at(2), (std::array<float, 3>{0, 0, 1}));
  EXPECT_EQ(loaded.scene.shapes[0].to_world, Transform{});

  file.json["scenes"][0]["nodes"].erase(2);
  EXPECT_EQ(error_of_bytes(file.glb()).place().key, "/skins/0/joints/1");
  file.json["skins"][0]["joints"] = nlohmann::json::array({still});
  const Error beyond = error_of_bytes(file.glb());
  EXPECT_EQ(beyond.place().key, "/meshes/0/primitives/0/attributes/JOINTS_0");
  EXPECT_THAT(beyond.message(), HasSubstr("vertex 1 names joint 1"));
}

TEST(GltfSkin, the_outer_side_stays_outside_where_joints_mirror) {
  GltfFile file;
  file.with_triangle();
  nlohmann::json& attributes = file.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["NORMAL"] = file.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  attributes["TANGENT"] = file.floats({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1}, "VEC4");
  attributes["JOINTS_0"] =
      file.accessor<std::uint8_t>({1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, "VEC4", 5121);
  attributes["WEIGHTS_0"] = file.floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  file.json["nodes"][0]["skin"] = 0;
  const int still = file.node(nlohmann::json::object());
  const int mirror = file.node({{"scale", {-1, 1, 1}}});
  file.json["skins"] = {{{"joints", {still, mirror}}}};
  // Two of three corners are mirrored: it goes with them.
  const Mesh mesh = mesh_of(file.load().scene.shapes.at(0));
  EXPECT_EQ(mesh.triangles.at(0), (std::array<std::uint32_t, 3>{0, 2, 1}));
  EXPECT_EQ(mesh.normals.at(0), (std::array<float, 3>{0, 0, 1}));
  EXPECT_EQ(mesh.tangents.at(0), (std::array<float, 4>{-1, 0, 0, -1}));
  EXPECT_EQ(mesh.tangents.at(2), (std::array<float, 4>{1, 0, 0, 1}));
  // One of three does not turn it.
  file.json["skins"][0]["joints"] = {mirror, still};
  EXPECT_EQ(mesh_of(file.load().scene.shapes.at(0)).triangles.at(0),
            (std::array<std::uint32_t, 3>{0, 1, 2}));
}

}  // namespace
}  // namespace tessera::scene
