#include "common/scene/outline.hpp"

#include <gtest/gtest.h>

#include "tests/unit/scene/gltf_file.hpp"

namespace tessera::scene {
namespace {

void expect_same(const MeshSize& one, const MeshSize& other) {
  EXPECT_EQ(one.positions, other.positions);
  EXPECT_EQ(one.normals, other.normals);
  EXPECT_EQ(one.uvs, other.uvs);
  EXPECT_EQ(one.uvs1, other.uvs1);
  EXPECT_EQ(one.tangents, other.tangents);
  EXPECT_EQ(one.colors, other.colors);
  EXPECT_EQ(one.triangles, other.triangles);
}

TEST(Outline, HasTheSizeOfTheMeshAndTheCornersOfItsBox) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {0, 0, -4}};
  mesh.normals.resize(4);
  mesh.uvs.resize(4);
  mesh.uvs1.resize(3);
  mesh.tangents.resize(4);
  mesh.colors.resize(4);
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}};
  const MeshSize whole = size_of(mesh);
  EXPECT_EQ(whole.uvs, 4U);
  EXPECT_EQ(whole.uvs1, 3U);
  keep_outline(mesh);
  expect_same(size_of(mesh), whole);
  EXPECT_EQ(mesh.positions.size(), 8U);
  EXPECT_EQ(mesh.positions.front(), (std::array<float, 3>{0, 0, -4}));
  EXPECT_EQ(mesh.positions.back(), (std::array<float, 3>{2, 3, 0}));
  EXPECT_TRUE(mesh.triangles.empty() && mesh.normals.empty() && mesh.colors.empty());
  keep_outline(mesh);
  expect_same(size_of(mesh), whole);
}

TEST(Outline, IsAllThatASurveyKeepsOfMeshesInFilesHoweverTheyAreNamed) {
  const TemporaryFolder folder;
  GltfFile model;
  model.with_triangle();
  folder.write("model.glb", model.glb());
  folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 3 4\n");
  folder.write("s.json", R"({"tessera": 1, "include": [{"file": "model.glb"}],
    "materials": {"m": {"type": "diffuse"}},
    "shapes": [{"type": "mesh", "file": "m.obj", "material": "m"}],
    "objects": {"o": {"shapes": [{"type": "mesh", "file": "m.obj", "material": "m"}]}}})");
  const FolderFiles files(folder.path());
  const Scene read = load_scene(files, "s.json").scene;
  const Scene surveyed = survey_scene(files, "s.json").scene;
  const auto expect_outline = [](const Shape& of, const Shape& shape) {
    const Mesh& mesh = mesh_of(shape);
    EXPECT_TRUE(mesh.outlined && mesh.triangles.empty());
    expect_same(size_of(mesh), size_of(mesh_of(of)));
  };
  ASSERT_EQ(surveyed.shapes.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) expect_outline(read.shapes[i], surveyed.shapes[i]);
  expect_outline(read.objects.at(0).shapes.at(0), surveyed.objects.at(0).shapes.at(0));
  EXPECT_TRUE(mesh_of(survey_scene(files, "model.glb").scene.shapes.at(0)).outlined);
}

}  // namespace
}  // namespace tessera::scene
