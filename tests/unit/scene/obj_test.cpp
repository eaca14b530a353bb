#include "common/scene/obj.hpp"

#include <gtest/gtest.h>

#include <string>

#include "common/base/error.hpp"

namespace tessera::scene {
namespace {

const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST(Obj, polygons_become_triangles_over_shared_positions) {
  const Mesh mesh = parse_obj(square + "f 1 2 3 4\n", "a.obj");
  EXPECT_EQ(mesh.positions.size(), 4U);
  EXPECT_EQ(mesh.triangles.size(), 2U);
  EXPECT_TRUE(mesh.normals.empty());
  EXPECT_TRUE(mesh.uvs.empty());
}

TEST(Obj, winding_is_kept) {
  const Mesh mesh = parse_obj(square + "f 3 4 1\n", "a.obj");
  EXPECT_EQ(mesh.triangles.at(0), (std::array<std::uint32_t, 3>{2, 3, 0}));
}

TEST(Obj, negative_indices_count_back_from_the_line_on_which_they_stand) {
  const Mesh mesh = parse_obj(
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 5\nv 1 0 5\nv 0 1 5\nf -3 -2 -1\n", "a.obj");
  EXPECT_EQ(mesh.triangles.at(1), (std::array<std::uint32_t, 3>{3, 4, 5}));
}

TEST(Obj, all_groups_objects_and_materials_are_one_mesh) {
  const Mesh mesh = parse_obj("mtllib /etc/passwd\r\n" + square +
                                  "o one\nusemtl red\nf 1 2 3\ng two\ns 1\nf 1 3 4\r\nl 1 2\np 1\n",
                              "a.obj");
  EXPECT_EQ(mesh.triangles.size(), 2U);
}

TEST(Obj, a_vertex_with_two_normals_becomes_two) {
  const Mesh mesh = parse_obj(
      square + "vn 0 0 1\nvn 1 0 0\nvt 0 0.25\nf 1/1/1 2/1/1 3/1/1\nf 1/1/2 3/1/1 4/1/1\n",
      "a.obj");
  EXPECT_EQ(mesh.positions.size(), 5U);
  ASSERT_EQ(mesh.normals.size(), 5U);
  ASSERT_EQ(mesh.uvs.size(), 5U);
  EXPECT_EQ(mesh.triangles.at(0)[2], mesh.triangles.at(1)[1]);
  EXPECT_NE(mesh.triangles.at(0)[0], mesh.triangles.at(1)[0]);
  EXPECT_EQ(mesh.normals.at(mesh.triangles.at(1)[0]), (std::array<float, 3>{1, 0, 0}));
  EXPECT_EQ(mesh.uvs.at(0), (std::array<float, 2>{0, 0.75})) << "v runs up in the file";
}

TEST(Obj, a_face_without_normals_among_others_gets_that_of_its_plane) {
  const Mesh mesh = parse_obj(square + "vn 1 0 0\nf 1//1 2//1 3//1\nf 1 3 4\n", "a.obj");
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  EXPECT_EQ(mesh.normals.at(mesh.triangles.at(0)[0]), (std::array<float, 3>{1, 0, 0}));
  EXPECT_EQ(mesh.normals.at(mesh.triangles.at(1)[0]), (std::array<float, 3>{0, 0, 1}));
}

TEST(Obj, a_face_with_a_normal_of_no_length_gets_that_of_its_plane) {
  const Mesh mesh =
      parse_obj(square + "vn 1 0 0\nvn 0 0 0\nf 1//1 2//1 3//1\nf 1//1 3//2 4//1\n", "a.obj");
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  for (const std::uint32_t corner : mesh.triangles.at(0))
    EXPECT_EQ(mesh.normals.at(corner), (std::array<float, 3>{1, 0, 0}));
  for (const std::uint32_t corner : mesh.triangles.at(1))
    EXPECT_EQ(mesh.normals.at(corner), (std::array<float, 3>{0, 0, 1}));
}

struct Broken {
  const char* behind;  ///< the square's four lines
  int line;
  const char* message;
};
class BrokenObj : public testing::TestWithParam<Broken> {};

TEST_P(BrokenObj, is_refused_with_its_line) {
  try {
    (void)parse_obj(square + GetParam().behind, "a.obj");
    FAIL() << "accepted: " << GetParam().behind;
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::bad_input);
    EXPECT_EQ(error.place().file, "a.obj");
    EXPECT_EQ(error.place().line, GetParam().line) << error.what();
    EXPECT_NE(error.message().find(GetParam().message), std::string::npos) << error.what();
  }
}

const Broken broken[] = {
    {"f 1 2\n", 5, "a face of 3 to 256 corners, found 2"},
    {"f 1 2 5\n", 5, "position 5 is out of range: the file has 4"},
    {"f 1 2 99999999999\n", 5, "out of range"},
    {"f 1 2 99999999999999999999\n", 5, "expected a corner"},
    {"f 1 2 0\n", 5, "counting from 1"},
    {"f 1 2 -5\n", 5, "names a position before the first"},
    {"f 1//1 2//1 3//1\n", 5, "normal 1 is out of range: the file has 0"},
    {"vt 0 0\nf 1/2 2/1 3/1\n", 6, "texture coordinate 2 is out of range"},
    {"f 1/ 2 3\n", 5, "expected a corner"},
    {"f 1/1/1/1 2 3\n", 5, "expected a corner"},
    {"f 1 2 3 # no\n", 5, "found \"#\""},
    {"f 1 2 x\n", 5, "found \"x\""},
    {"v 1 2\nf 1 2 3\n", 5, "expected 3 to 7 numbers, found 2"},
    {"v 1 2 nan\nf 1 2 3\n", 5, "found \"nan\""},
    {"v 1 2 inf\nf 1 2 3\n", 5, "found \"inf\""},
    {"v 1 2 1e400\nf 1 2 3\n", 5, "found \"1e400\""},
    {"v 1 2 1e20\nf 1 2 3\n", 5, "found \"1e20\""},
    {"v 1 2 3x\nf 1 2 3\n", 5, "found \"3x\""},
    {"v 1 2 \\\n3\n", 5, "found \"\\\""},
    {"vn 1 2\nf 1 2 3\n", 5, "expected 3 to 3 numbers"},
    {"hello\n", 5, "unknown statement \"hello\""},
    {"t crease 2000000000/0/0 1\n", 5, "unknown statement \"t\""},
    {"# comment\rf 9 9 9\n", 5, "a carriage return within a line"},
    {"", 0, "has no faces"},
    {"l 0 1\nf 1 2 3\n", 0, "not a good OBJ file"},
};
INSTANTIATE_TEST_SUITE_P(All, BrokenObj, testing::ValuesIn(broken));

TEST(Obj, bytes_that_are_no_text_are_refused) {
  EXPECT_THROW((void)parse_obj(std::string("\x7f"
                                           "ELF\0\0\0",
                                           7),
                               "a.obj"),
               Error);
  EXPECT_THROW((void)parse_obj(square + std::string("# \0\nf 1 2 3\n", 12), "a.obj"), Error);
}

TEST(Obj, a_polygon_of_too_many_corners_is_refused) {
  std::string face = "f";
  for (int i = 0; i < 257; ++i) face += " 1";
  EXPECT_THROW((void)parse_obj(square + face + "\n", "a.obj"), Error);
}

TEST(Obj, no_changed_byte_makes_a_crash_or_an_index_out_of_range) {
  std::string text = square + "vn 0 0 1\nvt 0 0\nf 1/1/1 2/1/1 3/1/1 4/1/1\nf -1 -2 -3\n";
  for (std::size_t at = 0; at < text.size(); ++at)
    for (const char byte : {'0', '9', '-', '/', ' ', '\n', '\r', 'f', 'v', '\xff', 'e', '.'}) {
      const char before = text[at];
      text[at] = byte;
      try {
        const Mesh mesh = parse_obj(text, "a.obj");
        for (const auto& triangle : mesh.triangles)
          for (const std::uint32_t index : triangle)
            ASSERT_LT(index, mesh.positions.size()) << text;
        ASSERT_TRUE(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size());
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::bad_input);
      }
      text[at] = before;
    }
}

}  // namespace
}  // namespace tessera::scene
