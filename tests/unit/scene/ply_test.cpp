#include "common/scene/ply.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "tests/unit/scene/support.hpp"

namespace tessera::scene {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Point = std::array<float, 3>;
using Triangle = std::array<std::uint32_t, 3>;

std::string head(const std::string& format, const std::string& elements) {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\n" + elements + "end_header\n";
}
constexpr const char* square_elements =
    "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\n";

template <class T>
std::string bytes_of(const std::vector<T>& values, bool big) {
  std::string out;
  for (const T value : values) {
    std::array<char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), &value, sizeof(T));
    if (big) std::reverse(bytes.begin(), bytes.end());
    out.append(bytes.data(), bytes.size());
  }
  return out;
}

std::string binary_square(bool big) {
  return head(big ? "binary_big_endian" : "binary_little_endian", square_elements) +
         bytes_of<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, big) + "\4" +
         bytes_of<std::int32_t>({0, 1, 2, 3}, big);
}

std::string message_of(const std::string& bytes) {
  try {
    (void)parse_ply(bytes, "m.ply");
  } catch (const Error& error) {
    EXPECT_EQ(error.place().file, "m.ply");
    return error.message();
  }
  return "no error";
}

void expect_square(const Mesh& mesh) {
  EXPECT_THAT(mesh.positions,
              ElementsAre(Point{0, 0, 0}, Point{1, 0, 0}, Point{1, 1, 0}, Point{0, 1, 0}));
  EXPECT_THAT(mesh.triangles, ElementsAre(Triangle{0, 1, 2}, Triangle{0, 2, 3}));
}

TEST(Ply, is_the_same_in_all_three_formats) {
  expect_square(parse_ply(binary_square(false), "m.ply"));
  expect_square(parse_ply(binary_square(true), "m.ply"));
  expect_square(parse_ply(
      head("ascii", square_elements) + "0 0 0\r\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n", "m.ply"));
}

TEST(Ply, normals_coordinates_and_colours_come_along) {
  const Mesh mesh = parse_ply(
      head("ascii",
           "element vertex 3\nproperty double x\nproperty float y\nproperty int z\n"
           "property float nx\nproperty float ny\nproperty float nz\n"
           "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float quality\n"
           "property float s\nproperty float t\n"
           "element face 1\nproperty uchar flags\nproperty list uchar uint vertex_index\n"
           "element edge 1\nproperty int a\n") +
          "0 0 0 0 0 2 255 0 188 9 .25 .25\n1 0 0 0 0 1 0 0 0 9 0 0\n0 1 0 0 0 1 0 0 0 9 1 1\n"
          "7 3 0 1 2\n5\n",
      "m.ply");
  EXPECT_EQ(mesh.normals.at(0), (Point{0, 0, 2}));
  EXPECT_EQ(mesh.uvs.at(0), (std::array<float, 2>{.25F, .75F})) << "v runs up in the file";
  EXPECT_EQ(mesh.colors.at(0)[0], 1);
  EXPECT_NEAR(mesh.colors.at(0)[2], 0.5029, 1e-4) << "bytes are sRGB";
  EXPECT_EQ(mesh.colors.at(0)[3], 1);
  EXPECT_THAT(mesh.triangles, ElementsAre(Triangle{0, 1, 2}));
}

TEST(Ply, whole_numbers_are_colours_by_their_greatest) {
  const Mesh mesh =
      parse_ply(head("ascii",
                     "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                     "property ushort red\nproperty ushort green\nproperty ushort blue\n"
                     "element face 1\nproperty list uchar uint vertex_index\n") +
                    "0 0 0 65535 0 48316\n1 0 0 0 0 0\n0 1 0 0 0 0\n3 0 1 2\n",
                "m.ply");
  EXPECT_EQ(mesh.colors.at(0)[0], 1);
  EXPECT_NEAR(mesh.colors.at(0)[2], 0.5029, 1e-4);
}

TEST(Ply, vertices_of_numbers_that_are_none_are_refused) {
  std::string numbers;
  const auto add = [&](float value) {
    numbers.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (const float value : {0.F, 0.F, 0.F, 0.F, std::numeric_limits<float>::quiet_NaN(), 1.F, 0.F,
                            0.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F})
    add(value);
  EXPECT_THAT(message_of(head("binary_little_endian",
                              "element vertex 3\nproperty float x\nproperty float y\n"
                              "property float z\nproperty float s\nproperty float t\n"
                              "element face 1\nproperty list uchar uchar vertex_index\n") +
                         numbers + std::string("\3\0\1\2", 4)),
              HasSubstr("vertex 0 has a number that is none"));
  EXPECT_THAT(message_of(head("ascii",
                              "element vertex 1\nproperty float x\nproperty float x\n"
                              "property float y\n") +
                         "1 1 1\n"),
              HasSubstr("\"x\" twice"));
}

TEST(Ply, a_file_cut_off_anywhere_is_refused) {
  const std::string whole = binary_square(false);
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_NE(message_of(whole.substr(0, size)), "no error") << size;
}

TEST(Ply, what_is_wrong_is_said) {
  const std::string vertices = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  const auto square = [&](const std::string& face) {
    return message_of(head("ascii", square_elements) + vertices + face);
  };
  EXPECT_THAT(square("3 0 1 4\n"), HasSubstr("names vertex 4, and there are 4"));
  EXPECT_THAT(square("3 0 1 -1\n"), HasSubstr("face 0 of 1"));
  EXPECT_THAT(square("2 0 1\n"), HasSubstr("no face"));
  EXPECT_THAT(message_of("solid\n"), HasSubstr("no PLY file"));
  EXPECT_THAT(message_of("ply\nformat binary_littel_endian 1.0\nend_header\n"),
              HasSubstr("did you mean \"binary_little_endian\"?"));
  EXPECT_THAT(message_of(head("ascii", "element vertex 3\nproperty flaot x\n")),
              HasSubstr("did you mean \"float\"?"));
  EXPECT_THAT(message_of(head("ascii", "element vertex 1\nproperty float x\n") + "1\n"),
              HasSubstr("x, y and z"));
  EXPECT_THAT(message_of(head("binary_little_endian",
                              "element vertex 4000000000\nproperty float x\nproperty float y\n"
                              "property float z\n")),
              HasSubstr("has not the bytes"));
  EXPECT_THAT(message_of(head("ascii", "element nothing 99999999999\n")),
              HasSubstr("has not the bytes"));
  EXPECT_THAT(message_of("ply\n" + std::string(100000, 'x')), HasSubstr("no end"));
}

TEST(Ply, stands_beside_obj_in_a_scene) {
  const TemporaryFolder folder;
  folder.write("m.ply", binary_square(false));
  const auto file = folder.write(
      "s.json",
      scene_with("\"materials\": {\"m\": {\"type\": \"diffuse\"}}, \"shapes\": [{\"type\": "
                 "\"mesh\", \"material\": \"m\", \"file\": \"m.ply\"}],"));
  const LoadedScene loaded = load_scene(file);
  expect_square(std::get<Mesh>(loaded.scene.shapes.at(0).geometry));
  EXPECT_EQ(loaded.files.size(), 2U);
}

}  // namespace
}  // namespace tessera::scene
