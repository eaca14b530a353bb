#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include "tests/unit/scene/gltf_file.hpp"

namespace tessera::scene {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using Triangle = std::array<std::uint32_t, 3>;
using Point = std::array<float, 3>;

const std::vector<float> square{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};

Mesh only_mesh(const GltfFile& file) {
  const LoadedScene loaded = file.load();
  EXPECT_EQ(loaded.scene.shapes.size(), 1U);
  return mesh_of(loaded.scene.shapes.at(0));
}

/// A square's primitive with more members, on a node.
Mesh square_with(GltfFile& file, nlohmann::json members) {
  members["attributes"]["POSITION"] = file.floats(square, "VEC3");
  file.node({{"mesh", file.mesh(members)}});
  return only_mesh(file);
}

TEST(GltfMesh, every_mode_that_has_area_becomes_triangles) {
  GltfFile list, strip, fan;
  EXPECT_THAT(square_with(list, {{"indices", list.indices({0, 1, 2, 0, 2, 3})}}).triangles,
              ElementsAre(Triangle{0, 1, 2}, Triangle{0, 2, 3}));
  EXPECT_THAT(square_with(strip, {{"indices", strip.indices({1, 2, 0, 3})}, {"mode", 5}}).triangles,
              ElementsAre(Triangle{1, 2, 0}, Triangle{2, 3, 0}));
  EXPECT_THAT(square_with(fan, {{"mode", 6}}).triangles,
              ElementsAre(Triangle{1, 2, 0}, Triangle{2, 3, 0}));
}

TEST(GltfMesh, points_and_lines_are_passed_over_with_a_warning) {
  for (int mode = 0; mode < 4; ++mode) {
    GltfFile file;
    file.with_triangle();
    const int positions = file.floats(square, "VEC3");
    file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", positions}}}, {"mode", mode}})}});
    const LoadedScene loaded = file.load();
    EXPECT_EQ(loaded.scene.shapes.size(), 1U) << mode;
    EXPECT_THAT(loaded.warnings, testing::Contains(testing::HasSubstr("points and lines")));
  }
}

TEST(GltfMesh, triangles_without_area_that_join_strips_are_left_out) {
  GltfFile file;
  const Mesh mesh = square_with(file, {{"indices", file.indices({0, 1, 3, 3, 3, 2})}, {"mode", 5}});
  EXPECT_THAT(mesh.triangles, ElementsAre(Triangle{0, 1, 2}));
  EXPECT_THAT(mesh.positions, ElementsAre(Point{0, 0, 0}, Point{1, 0, 0}, Point{0, 1, 0}));
}

TEST(GltfMesh, all_attributes_come_along) {
  GltfFile file;
  const Mesh mesh = square_with(
      file, {{"mode", 6},
             {"attributes",
              {{"NORMAL", file.floats({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3")},
               {"TANGENT", file.floats({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, -1, 1, 0, 0, 1}, "VEC4")},
               {"TEXCOORD_0", file.floats({0, 1, 1, 1, 1, 0, 0, 0}, "VEC2")},
               {"TEXCOORD_1", file.floats({2, 2, 3, 3, 4, 4, 5, 5}, "VEC2")},
               {"COLOR_0", file.floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 2, 1, 1}, "VEC3")}}}});
  EXPECT_EQ(mesh.normals.at(3), (Point{0, 0, 1}));
  EXPECT_EQ(mesh.tangents.at(2), (std::array<float, 4>{1, 0, 0, -1}));
  EXPECT_EQ(mesh.uvs.at(0), (std::array<float, 2>{0, 1}));
  EXPECT_EQ(mesh.uvs1.at(3), (std::array<float, 2>{5, 5}));
  EXPECT_EQ(mesh.colors.at(1), (std::array<float, 4>{0, 1, 0, 1}));
  EXPECT_EQ(mesh.colors.at(3), (std::array<float, 4>{1, 1, 1, 1})) << "0…1";
}

TEST(GltfMesh, tangents_say_nothing_without_normals) {
  GltfFile file;
  const Mesh mesh = square_with(
      file,
      {{"mode", 6},
       {"attributes",
        {{"TANGENT", file.floats({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, -1, 1, 0, 0, 1}, "VEC4")}}}});
  EXPECT_TRUE(mesh.tangents.empty());
  EXPECT_TRUE(mesh.normals.empty());
}

TEST(GltfMesh, a_normal_without_length_becomes_its_face_s) {
  GltfFile file;
  const Mesh mesh = square_with(
      file,
      {{"mode", 6},
       {"attributes", {{"NORMAL", file.floats({0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0}, "VEC3")}}}});
  EXPECT_EQ(mesh.normals.at(0), (Point{0, 1, 0}));
  EXPECT_EQ(mesh.normals.at(1), (Point{0, 0, 1}));
}

TEST(GltfMesh, integers_are_read_as_the_fractions_that_they_stand_for) {
  GltfFile file;
  const int bytes = file.accessor<std::uint8_t>({0, 255, 51, 0, 255, 0, 0, 0}, "VEC2", 5121);
  const int shorts = file.accessor<std::int16_t>({32767, -32768, 0, 0, 0, 0, 0, 0}, "VEC2", 5122);
  file.json["accessors"][bytes]["normalized"] = true;
  file.json["accessors"][shorts]["normalized"] = true;
  const Mesh mesh = square_with(
      file, {{"mode", 6}, {"attributes", {{"TEXCOORD_0", bytes}, {"TEXCOORD_1", shorts}}}});
  EXPECT_EQ(mesh.uvs.at(0), (std::array<float, 2>{0, 1}));
  EXPECT_EQ(mesh.uvs.at(1), (std::array<float, 2>{0.2F, 0}));
  EXPECT_EQ(mesh.uvs1.at(0), (std::array<float, 2>{1, -1}));
}

TEST(GltfMesh, quantised_positions_are_read_as_they_stand) {
  GltfFile file;
  file.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  const int positions =
      file.accessor<std::int16_t>({-5, 0, 0, 0, 700, 0, 0, 0, 0, 7, 0, 0}, "VEC3", 5122);
  // Eight bytes an element, as alignment wants it.
  file.json["bufferViews"][0]["byteStride"] = 8;
  file.json["accessors"][positions]["count"] = 3;
  file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", positions}}}})}});
  EXPECT_THAT(only_mesh(file).positions,
              ElementsAre(Point{-5, 0, 0}, Point{700, 0, 0}, Point{0, 7, 0}));
}

TEST(GltfMesh, interleaved_attributes_are_told_apart) {
  GltfFile file;
  const int view = file.view<float>({0, 0, 0, .1F, .2F, 1, 0, 0, .3F, .4F, 0, 1, 0, .5F, .6F});
  file.json["bufferViews"][view]["byteStride"] = 20;
  file.json["accessors"] = {
      {{"bufferView", view}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}},
      {{"bufferView", view},
       {"byteOffset", 12},
       {"componentType", 5126},
       {"count", 3},
       {"type", "VEC2"}}};
  file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", 0}, {"TEXCOORD_0", 1}}}})}});
  const Mesh mesh = only_mesh(file);
  EXPECT_EQ(mesh.positions.at(2), (Point{0, 1, 0}));
  EXPECT_EQ(mesh.uvs.at(1), (std::array<float, 2>{.3F, .4F}));
}

TEST(GltfMesh, sparse_accessors_change_some_elements_or_stand_on_zeros) {
  GltfFile file;
  const nlohmann::json sparse{
      {"count", 2},
      {"indices", {{"bufferView", file.view<std::uint8_t>({1, 2})}, {"componentType", 5121}}},
      {"values", {{"bufferView", file.view<float>({5, 0, 0, 0, 6, 0})}}}};
  const int changed = file.floats({9, 9, 9, 1, 1, 1, 2, 2, 2}, "VEC3");
  file.json["accessors"][changed]["sparse"] = sparse;
  file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", changed}}}})}});
  EXPECT_THAT(only_mesh(file).positions,
              ElementsAre(Point{9, 9, 9}, Point{5, 0, 0}, Point{0, 6, 0}));
  file.json["accessors"][changed].erase("bufferView");
  EXPECT_THAT(only_mesh(file).positions,
              ElementsAre(Point{0, 0, 0}, Point{5, 0, 0}, Point{0, 6, 0}));
}

TEST(GltfMesh, vertices_that_no_triangle_uses_are_dropped) {
  GltfFile file;
  const int positions = file.floats({9, 9, 9, 0, 0, 0, 9, 9, 9, 1, 0, 0, 9, 9, 9, 0, 1, 0}, "VEC3");
  file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", positions}}},
                                 {"indices", file.indices({1, 3, 5})}})}});
  const Mesh mesh = only_mesh(file);
  EXPECT_THAT(mesh.positions, ElementsAre(Point{0, 0, 0}, Point{1, 0, 0}, Point{0, 1, 0}));
  EXPECT_THAT(mesh.triangles, ElementsAre(Triangle{0, 1, 2}));
}

TEST(GltfMesh, compressed_buffer_views_are_unpacked) {
  GltfFile file;
  const std::vector<float> positions{0, 0, 0, 0.5F, 0, 0, 0, 0.25F, 0};
  std::vector<unsigned char> packed(meshopt_encodeVertexBufferBound(3, 12));
  packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), positions.data(), 3, 12));
  const std::vector<unsigned int> corners{2, 0, 1};
  std::vector<unsigned char> packed_corners(meshopt_encodeIndexBufferBound(3, 3));
  packed_corners.resize(
      meshopt_encodeIndexBuffer(packed_corners.data(), packed_corners.size(), corners.data(), 3));
  file.json["extensionsRequired"] = {"EXT_meshopt_compression"};
  const auto meshopt = [&](int view, std::size_t bytes, int stride, const std::string& mode) {
    nlohmann::json& json = file.json["bufferViews"][view];
    json["extensions"]["EXT_meshopt_compression"] = {
        {"buffer", 0},         {"byteOffset", json["byteOffset"]},
        {"byteLength", bytes}, {"byteStride", stride},
        {"count", 3},          {"mode", mode}};
    // What is unpacked stands in for a buffer that is not there.
    json["buffer"] = 1;
    json["byteOffset"] = 0;
    json["byteLength"] = 3 * stride;
  };
  const int view = file.view(packed), corner_view = file.view(packed_corners);
  meshopt(view, packed.size(), 12, "ATTRIBUTES");
  meshopt(corner_view, packed_corners.size(), 2, "TRIANGLES");
  file.json["buffers"].push_back(
      {{"byteLength", 36}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
  file.json["accessors"] = {
      {{"bufferView", view}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}},
      {{"bufferView", corner_view}, {"componentType", 5123}, {"count", 3}, {"type", "SCALAR"}}};
  file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", 0}}}, {"indices", 1}})}});
  const Mesh mesh = only_mesh(file);
  EXPECT_THAT(mesh.positions, ElementsAre(Point{0, 0, 0}, Point{0.5F, 0, 0}, Point{0, 0.25F, 0}));
  // The codec keeps a triangle, and may begin it at another corner.
  EXPECT_THAT(mesh.triangles,
              ElementsAre(testing::AnyOf(Triangle{2, 0, 1}, Triangle{0, 1, 2}, Triangle{1, 2, 0})));
}

TEST(GltfMesh, parts_that_share_vertices_may_read_them_again_and_again) {
  GltfFile file;
  constexpr std::size_t vertices = 40'000, parts = 1500;  // 720 MB read, 50 kB kept
  std::vector<float> positions(3 * vertices);
  for (std::size_t i = 0; i < vertices; ++i) positions[3 * i + i % 3] = 1;
  const int shared = file.floats(positions, "VEC3");
  const int corners = file.indices({0, 1, 2});
  nlohmann::json primitives = nlohmann::json::array();
  for (std::size_t i = 0; i < parts; ++i)
    primitives.push_back({{"attributes", {{"POSITION", shared}}}, {"indices", corners}});
  file.json["meshes"] = nlohmann::json::array({{{"primitives", primitives}}});
  file.node({{"mesh", 0}});
  const LoadedScene loaded = file.load();
  ASSERT_EQ(loaded.scene.shapes.size(), parts);
  EXPECT_EQ(mesh_of(loaded.scene.shapes.back()).positions.size(), 3U);
}

TEST(GltfMesh, what_no_picture_shows_of_vertices_is_said) {
  GltfFile file;
  file.with_triangle();
  auto& primitive = file.json["meshes"][0]["primitives"][0];
  const auto said = [&] { return file.load().warnings; };
  EXPECT_THAT(said(), Not(Contains(HasSubstr("passed over"))));
  const int pairs = file.floats({0, 0, 1, 0, 0, 1}, "VEC2");
  primitive["attributes"]["TEXCOORD_2"] = pairs;
  EXPECT_THAT(said(), Contains(HasSubstr("beyond the second are passed over")));
  primitive["targets"] = nlohmann::json::array({{{"TEXCOORD_0", pairs}}});
  EXPECT_THAT(said(), Contains(HasSubstr("morph targets' colours")));
}

}  // namespace
}  // namespace tessera::scene
