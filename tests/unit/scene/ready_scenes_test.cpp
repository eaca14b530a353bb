#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <vector>

#include "tests/unit/scene/support.hpp"

namespace tessera::scene {
namespace {

/// The ```json blocks of the format's reference.
std::vector<std::string> examples() {
  const std::string text = text_of_file(source_folder() / "scenes" / "README.md");
  std::vector<std::string> out;
  for (std::size_t at = text.find("```json\n"); at != std::string::npos;
       at = text.find("```json\n", at)) {
    at += 8;
    const std::size_t end = text.find("```", at);
    out.push_back(text.substr(at, end - at));
    at = end + 3;
  }
  return out;
}

TEST(ReadyScenes, every_example_of_the_reference_is_a_scene) {
  const TemporaryFolder folder;
  folder.write("models/teapot.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  for (const char* picture :
       {"leaf.png", "leaf-height.png", "oak.png", "oak-normal.png", "oak-roughness.png", "sky.hdr"})
    folder.write(picture, "x");
  const auto all = examples();
  ASSERT_GE(all.size(), 6U);
  for (const std::string& example : all)
    EXPECT_NO_THROW((void)parse_scene(example, "example", FolderFiles(folder.path()))) << example;
}

TEST(ReadyScenes, every_key_stands_in_an_example) {
  std::string all;
  for (const std::string& example : examples()) all += example;
  for (const char* key : {"normal_map",
                          "bump_map",
                          "height",
                          "clearcoat_normal_map",
                          "alpha_cutoff",
                          "studio",
                          "tessera",
                          "name",
                          "about",
                          "film",
                          "width",
                          "height",
                          "render",
                          "samples",
                          "bounces",
                          "integrator",
                          "sampler",
                          "filter",
                          "filter_width",
                          "light_samples",
                          "aovs",
                          "aovs_follow_specular",
                          "group",
                          "light_groups",
                          "seed",
                          "camera",
                          "cameras",
                          "eye",
                          "target",
                          "up",
                          "fov",
                          "focal_length",
                          "film_size",
                          "environment",
                          "radiance",
                          "materials",
                          "type",
                          "reflectance",
                          "textures",
                          "file",
                          "color_space",
                          "wrap",
                          "filter",
                          "uv_set",
                          "scale",
                          "rotation",
                          "offset",
                          "factor",
                          "channel",
                          "strength",
                          "ior",
                          "transmittance",
                          "two_sided",
                          "shapes",
                          "material",
                          "corner",
                          "edge_u",
                          "edge_v",
                          "center",
                          "radius",
                          "low",
                          "high",
                          "positions",
                          "normals",
                          "uvs",
                          "triangles",
                          "file",
                          "transform",
                          "translate",
                          "rotate",
                          "axis",
                          "degrees",
                          "scale",
                          "matrix",
                          "objects",
                          "instances",
                          "object",
                          "visibility",
                          "shadow",
                          "indirect",
                          "holdout",
                          "shadow_catcher",
                          "transparent",
                          "roughness",
                          "thin_walled",
                          "attenuation_color",
                          "attenuation_distance",
                          "priority",
                          "eta",
                          "k",
                          "anisotropy",
                          "anisotropy_rotation",
                          "base_color",
                          "metallic",
                          "specular",
                          "specular_color",
                          "transmission",
                          "clearcoat",
                          "clearcoat_roughness",
                          "emission",
                          "unlit",
                          "amount",
                          "opacity",
                          "back_culled"})
    EXPECT_NE(all.find("\"" + std::string(key) + "\":"), std::string::npos) << key;
}

TEST(ReadyScenes, every_file_of_the_folder_is_a_scene) {
  int found = 0;
  for (const auto& entry : std::filesystem::directory_iterator(source_folder() / "scenes"))
    if (entry.path().extension() == ".json") {
      ++found;
      EXPECT_NO_THROW((void)load_scene(entry.path())) << entry.path();
    }
  EXPECT_GE(found, 2);
}

double area(const std::array<float, 3>& a, const std::array<float, 3>& b,
            const std::array<float, 3>& c) {
  std::array<double, 3> u{}, v{};
  for (std::size_t i = 0; i < 3; ++i) {
    u[i] = static_cast<double>(b[i]) - a[i];
    v[i] = static_cast<double>(c[i]) - a[i];
  }
  return std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                    u[0] * v[1] - u[1] * v[0]) /
         2;
}

double area(const Mesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles)
    sum += area(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]);
  return sum;
}

TEST(ReadyScenes, every_one_is_read_with_all_its_files) {
  int count = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(source_folder() / "scenes")) {
    if (entry.path().extension() != ".json") continue;
    EXPECT_NO_THROW((void)load_scene(entry.path())) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 4);
}

TEST(ReadyScenes, the_cornell_box_has_its_measured_numbers) {
  const Scene scene = load_scene(source_folder() / "scenes" / "cornell.json").scene;
  EXPECT_EQ(scene.render.width, 512);
  EXPECT_EQ(scene.render.height, 512);
  EXPECT_EQ(scene.cameras.at(0).eye, (Vec3{278, 273, -800}));
  EXPECT_NEAR(scene.cameras.at(0).fov_y_degrees, 39.30765, 1e-5);
  const auto shape = [&](const std::string& name) -> const Shape& {
    for (const Shape& one : scene.shapes)
      if (one.name == name) return one;
    throw std::runtime_error("no " + name);
  };
  const Quad& light = std::get<Quad>(shape("light").geometry);
  EXPECT_EQ(light.corner, (Vec3{343, 548.8, 227}));
  EXPECT_EQ(light.corner[0] + light.edge_u[0] + light.edge_v[0], 213);
  EXPECT_EQ(light.corner[2] + light.edge_u[2] + light.edge_v[2], 332);
  EXPECT_LT(light.edge_u[2] * light.edge_v[0] - light.edge_u[0] * light.edge_v[2],
            0);  // it shines down
  // The ceiling without the light's hole.
  EXPECT_NEAR(area(std::get<Mesh>(shape("ceiling").geometry)), 556 * 559.2 - 130 * 105, 0.1);
  EXPECT_NEAR(area(std::get<Mesh>(shape("floor").geometry)), (552.8 + 549.6) / 2 * 559.2, 0.1);
  EXPECT_EQ(std::get<Mesh>(shape("short block").geometry).positions.at(2),
            (std::array<float, 3>{240, 165, 272}));
  EXPECT_EQ(std::get<Mesh>(shape("tall block").geometry).positions.at(5),
            (std::array<float, 3>{265, 0, 296}));
}

/// The volume, signed: positive if all triangles of a closed mesh are counter-clockwise from
/// outside.
double volume(const Mesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const auto &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    sum += a[0] * (static_cast<double>(b[1]) * c[2] - static_cast<double>(b[2]) * c[1]) -
           a[1] * (static_cast<double>(b[0]) * c[2] - static_cast<double>(b[2]) * c[0]) +
           a[2] * (static_cast<double>(b[0]) * c[1] - static_cast<double>(b[1]) * c[0]);
  }
  return sum / 6;
}

TEST(ReadyScenes, the_blocks_are_turned_outwards) {
  const Scene scene = load_scene(source_folder() / "scenes" / "cornell.json").scene;
  for (const Shape& shape : scene.shapes)
    if (shape.name == "short block" || shape.name == "tall block") {
      const double height = shape.name == "short block" ? 165 : 330;
      // The lower side is open and lies in y = 0: it adds nothing.
      EXPECT_NEAR(volume(std::get<Mesh>(shape.geometry)) / height, 26700, 1500) << shape.name;
    }
}

}  // namespace
}  // namespace tessera::scene
