#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/scene/gltf_file.hpp"

namespace tessera::scene {
namespace {

/// A field of hills over side × side squares: position, normal, uv at every corner.
std::unique_ptr<draco::Mesh> hills(int side) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(2 * side * side);
  const int position =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int normal = builder.AddAttribute(draco::GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32);
  const int uv = builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32);
  const auto point = [&](int i, int k) {
    const float x = static_cast<float>(i) / static_cast<float>(side);
    const float z = static_cast<float>(k) / static_cast<float>(side);
    return std::array<float, 3>{x, x * z, z};
  };
  const auto add = [&](int face, std::array<std::array<int, 2>, 3> corners) {
    std::array<std::array<float, 3>, 3> p{};
    for (std::size_t i = 0; i < 3; ++i) p[i] = point(corners[i][0], corners[i][1]);
    const std::array<std::array<float, 2>, 3> t{
        {{p[0][0], p[0][2]}, {p[1][0], p[1][2]}, {p[2][0], p[2][2]}}};
    const std::array<float, 3> up{0, 1, 0};
    const draco::FaceIndex at(static_cast<std::uint32_t>(face));
    builder.SetAttributeValuesForFace(position, at, p[0].data(), p[1].data(), p[2].data());
    builder.SetAttributeValuesForFace(normal, at, up.data(), up.data(), up.data());
    builder.SetAttributeValuesForFace(uv, at, t[0].data(), t[1].data(), t[2].data());
  };
  for (int i = 0; i < side; ++i)
    for (int k = 0; k < side; ++k) {
      const int face = 2 * (i * side + k);
      add(face, {{{i, k}, {i, k + 1}, {i + 1, k}}});
      add(face + 1, {{{i + 1, k}, {i, k + 1}, {i + 1, k + 1}}});
    }
  return builder.Finalize();
}

std::vector<char> packed(int side, int method, int speed = 5) {
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  encoder.SetSpeedOptions(speed, speed);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, 12);
  draco::EncoderBuffer out;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*hills(side), &out).ok());
  return {out.data(), out.data() + out.size()};
}

/// A file whose one mesh is in `bytes`. What its accessors say of counts is a fallback's.
GltfFile file_of(const std::vector<char>& bytes, int faces) {
  GltfFile file;
  const int view = file.view(bytes);
  file.json["extensionsRequired"] = nlohmann::json::array({"KHR_draco_mesh_compression"});
  const auto accessor = [](const char* type, int component, int count) {
    return nlohmann::json{{"type", type}, {"componentType", component}, {"count", count}};
  };
  file.json["accessors"] = {accessor("SCALAR", 5123, 3 * faces), accessor("VEC3", 5126, 9),
                            accessor("VEC3", 5126, 9), accessor("VEC2", 5126, 9)};
  const nlohmann::json ids{{"POSITION", 0}, {"NORMAL", 1}, {"TEXCOORD_0", 2}};
  file.node(
      {{"mesh", file.mesh({{"attributes", {{"POSITION", 1}, {"NORMAL", 2}, {"TEXCOORD_0", 3}}},
                           {"indices", 0},
                           {"extensions",
                            {{"KHR_draco_mesh_compression",
                              {{"bufferView", view}, {"attributes", ids}}}}}})}});
  return file;
}

double area_of(const Mesh& mesh) {
  double out = 0;
  for (const auto& t : mesh.triangles) {
    const auto &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    // As seen from above; z × x is y.
    out += 0.5 * ((b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2]));
  }
  return out;
}

TEST(GltfDraco, a_compressed_mesh_comes_out_as_it_went_in_by_both_methods) {
  for (const int method : {0, 1})
    for (const int speed : {0, 5, 10}) {
      const LoadedScene loaded = file_of(packed(12, method, speed), 288).load();
      const Mesh& mesh = mesh_of(loaded.scene.shapes.at(0));
      EXPECT_EQ(mesh.triangles.size(), 288U) << method << " " << speed;
      EXPECT_NEAR(area_of(mesh), 1, 1e-3) << "all face up";
      ASSERT_EQ(mesh.uvs.size(), mesh.positions.size());
      ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
      for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const auto& p = mesh.positions[i];
        EXPECT_NEAR(p[1], p[0] * p[2], 2e-4);
        EXPECT_NEAR(mesh.uvs[i][0], p[0], 4e-4);
        EXPECT_NEAR(mesh.uvs[i][1], p[2], 4e-4);
        EXPECT_NEAR(mesh.normals[i][1], 1, 1e-2);
      }
    }
}

TEST(GltfDraco, what_is_asked_for_and_not_there_is_an_error_with_its_place) {
  const std::vector<char> bytes = packed(4, 1);
  const auto message = [](const GltfFile& file) {
    const Error error = error_of_bytes(file.glb());
    return error.place().key + ": " + error.message();
  };
  const std::string place = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression: ";
  GltfFile file = file_of(bytes, 32);
  nlohmann::json& primitive = file.json["meshes"][0]["primitives"][0];
  nlohmann::json& ids = primitive["extensions"]["KHR_draco_mesh_compression"]["attributes"];
  ids["NORMAL"] = 7;
  EXPECT_EQ(message(file), place + "Draco's bytes have no attribute 7");
  ids["NORMAL"] = 2;
  EXPECT_EQ(message(file), place + "attribute 2 of Draco's bytes has 2 numbers an element, not 3");
  ids["NORMAL"] = 1;
  file.json["accessors"][1]["componentType"] = 5122;
  EXPECT_EQ(message(file),
            place + "attribute 0 of Draco's bytes has floats, and its accessor integers");
  file.json["accessors"][1]["componentType"] = 5126;
  primitive.erase("indices");
  EXPECT_THAT(message(file), testing::HasSubstr("primitives/0/indices: what is compressed"));
  EXPECT_EQ(message(file_of({'D', 'R', 'A', 'C', 'H'}, 32)), place + "not a buffer of Draco's");
}

TEST(GltfDraco, counts_are_bounded_before_memory_is_taken) {
  std::vector<char> bytes = packed(4, 0);
  // Behind the header's eleven bytes the sequential method says its faces, then its points.
  const std::vector<char> many{'\xff', '\xff', '\xff', '\xff', '\x07'};
  std::vector<char> faces = bytes, points = bytes;
  faces.erase(faces.begin() + 11);
  faces.insert(faces.begin() + 11, many.begin(), many.end());
  points.erase(points.begin() + 12);
  points.insert(points.begin() + 12, many.begin(), many.end());
  EXPECT_THAT(error_of_bytes(file_of(faces, 32).glb()).message(),
              testing::HasSubstr("2147483647 faces; 16777216 is the most"));
  EXPECT_THAT(error_of_bytes(file_of(points, 32).glb()).message(),
              testing::HasSubstr("2147483647 points; 16777216 is the most"));
  const std::vector<char> too_many_for_so_few_bytes{'\x80', '\x80', '\x80', '\x02'};
  faces = bytes;
  faces.erase(faces.begin() + 11);
  faces.insert(faces.begin() + 11, too_many_for_so_few_bytes.begin(),
               too_many_for_so_few_bytes.end());
  EXPECT_THAT(error_of_bytes(file_of(faces, 32).glb()).message(), testing::HasSubstr("damaged"));
}

TEST(GltfDraco, damaged_bytes_give_an_error_or_a_mesh_and_no_crash) {
  for (const int method : {0, 1}) {
    const std::vector<char> good = packed(6, method);
    std::uint32_t state = 12345;
    const auto draw = [&](std::size_t below) {
      state = state * 1664525U + 1013904223U;
      return (state >> 8) % below;
    };
    int refused = 0;
    for (int run = 0; run < 400; ++run) {
      std::vector<char> bytes = good;
      for (std::size_t change = 0; change <= draw(3); ++change)
        bytes[5 + draw(std::min<std::size_t>(bytes.size() - 5, run % 2 == 0 ? 60 : 4096))] =
            static_cast<char>(draw(256));
      if (run % 10 == 0) bytes.resize(6 + draw(bytes.size() - 6));
      try {
        const LoadedScene loaded = file_of(bytes, 72).load();
        for (const Shape& shape : loaded.scene.shapes)
          for (const auto& t : mesh_of(shape).triangles)
            for (const std::uint32_t corner : t) ASSERT_LT(corner, mesh_of(shape).positions.size());
      } catch (const Error&) {
        ++refused;
      }
    }
    EXPECT_GT(refused, 100) << "the damage is looked at";
  }
}

}  // namespace
}  // namespace tessera::scene
