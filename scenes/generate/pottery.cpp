#include "scenes/generate/pottery.hpp"

#include <fmt/format.h>

#include <array>
#include <string>

#include "common/image/picture.hpp"
#include "scenes/generate/folder.hpp"
#include "scenes/generate/glaze.hpp"
#include "scenes/generate/gltf_file.hpp"
#include "scenes/generate/noise.hpp"
#include "scenes/generate/pot.hpp"

namespace tessera::generate {

namespace {

using nlohmann::json;

constexpr std::size_t side = 512;  ///< texels
constexpr int boards = 3, in_a_row = pot_kinds / boards;
// Metres.
constexpr double spacing = 0.335, storey = 0.40, thickness = 0.03, depth = 0.36;
constexpr double width = in_a_row * spacing + 0.1;

/// Flat faces with their normals.
struct Faces {
  std::vector<std::array<float, 3>> positions, normals;
  std::vector<std::uint32_t> indices;

  void add(const Point& corner, const Point& u, const Point& v) {
    const auto first = static_cast<std::uint32_t>(positions.size());
    const Point n =
        unit({u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]});
    for (const auto& [s, t] :
         {std::array{0, 0}, std::array{1, 0}, std::array{1, 1}, std::array{0, 1}}) {
      std::array<float, 3> p{}, normal{};
      for (std::size_t k = 0; k < 3; ++k) {
        p[k] = static_cast<float>(corner[k] + s * u[k] + t * v[k]);
        normal[k] = static_cast<float>(n[k]);
      }
      positions.push_back(p);
      normals.push_back(normal);
    }
    for (const std::uint32_t k : {0U, 1U, 2U, 0U, 2U, 3U}) indices.push_back(first + k);
  }
  void add_box(const Point& low, const Point& size) {
    const Point x{size[0], 0, 0}, y{0, size[1], 0}, z{0, 0, size[2]};
    const Point high{low[0] + size[0], low[1] + size[1], low[2] + size[2]};
    const auto back = [](const Point& v) { return Point{-v[0], -v[1], -v[2]}; };
    add(low, y, x);
    add(low, z, y);
    add(low, x, z);
    add(high, back(x), back(y));
    add(high, back(y), back(z));
    add(high, back(z), back(x));
  }
};

json primitive(GltfFile& file, const Faces& faces, int material) {
  const int positions = file.positions(faces.positions);
  const int normals = file.accessor(faces.normals, Target::vertices);
  const int indices = file.accessor(faces.indices, Target::indices);
  return {{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}},
          {"indices", indices},
          {"material", material}};
}

json primitive(GltfFile& file, const Pot& pot, int material) {
  const int positions = file.positions(pot.positions);
  const int normals = file.accessor(pot.normals, Target::vertices);
  const int tangents = file.accessor(pot.tangents, Target::vertices);
  const int uvs = file.accessor(pot.uvs, Target::vertices);
  const int indices = file.accessor(pot.indices, Target::indices);
  return {
      {"attributes",
       {{"POSITION", positions}, {"NORMAL", normals}, {"TANGENT", tangents}, {"TEXCOORD_0", uvs}}},
      {"indices", indices},
      {"material", material}};
}

int glazed_material(GltfFile& file, const std::string& name, int kind) {
  const Glaze pictures = glaze(kind, side);
  const auto texture = [&](const char* what, const std::vector<std::uint8_t>& codes) {
    const int number =
        file.texture(fmt::format("{} {}", name, what),
                     image::encode_png(static_cast<int>(side), static_cast<int>(side), codes));
    return json{{"index", number}};
  };
  json out{{"name", name}};
  out["pbrMetallicRoughness"] = {
      {"baseColorTexture", texture("color", pictures.base_color)},
      {"metallicRoughnessTexture", texture("roughness", pictures.metallic_roughness)}};
  out["normalTexture"] = texture("normal", pictures.normal);
  return file.add("materials", std::move(out));
}

int plain_material(GltfFile& file, const char* name, const std::array<double, 3>& color,
                   double roughness) {
  return file.add("materials", {{"name", name},
                                {"pbrMetallicRoughness",
                                 {{"baseColorFactor", {color[0], color[1], color[2], 1.0}},
                                  {"metallicFactor", 0},
                                  {"roughnessFactor", roughness}}}});
}

/// `strength` in cd/m².
int lamp_material(GltfFile& file, const char* name, const std::array<double, 3>& color,
                  double strength) {
  return file.add(
      "materials",
      {{"name", name},
       {"emissiveFactor", color},
       {"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}}},
       {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", strength}}}}}});
}

/// A node's matrix that looks from `eye` to `target`.
json looking(const Point& eye, const Point& target) {
  const Point back = unit({eye[0] - target[0], eye[1] - target[1], eye[2] - target[2]});
  const Point right = unit({back[2], 0, -back[0]});
  const Point up{back[1] * right[2] - back[2] * right[1], back[2] * right[0] - back[0] * right[2],
                 back[0] * right[1] - back[1] * right[0]};
  return {right[0], right[1], right[2], 0, up[0],  up[1],  up[2],  0,
          back[0],  back[1],  back[2],  0, eye[0], eye[1], eye[2], 1};
}

void add_room(GltfFile& file) {
  Faces wood, wall, warm, cold;
  for (int board = 0; board <= boards; ++board)
    wood.add_box({-0.5 * width, board * storey - thickness, -0.5 * depth},
                 {width, thickness, depth});
  for (const double x : {-0.5 * width - thickness, 0.5 * width})
    wood.add_box({x, -thickness, -0.5 * depth}, {thickness, boards * storey + thickness, depth});
  wall.add({-8, -3, -0.5 * depth}, {16, 0, 0}, {0, 8, 0});
  warm.add({-3.2, 1.2, 2.0}, {0.35, 1.3, -0.2}, {0.55, 0, 0.95});
  cold.add({2.6, 0.2, 2.9}, {-0.3, 1.8, -0.2}, {0.7, 0, -1.3});
  json primitives = json::array();
  primitives.push_back(
      primitive(file, wood, plain_material(file, "wood", {0.30, 0.19, 0.11}, 0.55)));
  primitives.push_back(
      primitive(file, wall, plain_material(file, "wall", {0.62, 0.60, 0.56}, 0.9)));
  primitives.push_back(
      primitive(file, warm, lamp_material(file, "warm lamp", {1, 0.83, 0.64}, 34)));
  primitives.push_back(primitive(file, cold, lamp_material(file, "cold lamp", {0.72, 0.85, 1}, 9)));
  file.place("room", std::move(primitives), json::object());
}

/// Squares around and along a pot, twice as many around.
std::size_t squares_for(std::size_t triangles) {
  std::size_t along = 2;
  while (std::size_t{pot_kinds} * 4 * along * along < triangles) ++along;
  return along;
}

}  // namespace

void write_pottery(const std::filesystem::path& folder, std::size_t triangles) {
  make_folder(folder);
  GltfFile file("pottery");
  file.use_extension("KHR_materials_emissive_strength");
  const std::size_t along = squares_for(triangles);
  for (int kind = 0; kind < pot_kinds; ++kind) {
    const std::string name = fmt::format("pot {}", kind + 1);
    json primitives = json::array();
    primitives.push_back(
        primitive(file, pot(kind, 2 * along, along), glazed_material(file, name, kind)));
    const double x = spacing * (kind % in_a_row - 0.5 * (in_a_row - 1));
    const int board = kind / in_a_row;
    file.place(name, std::move(primitives), {{"translation", {x, board * storey, 0.0}}});
  }
  add_room(file);
  const int camera = file.add(
      "cameras", {{"type", "perspective"},
                  {"perspective", {{"aspectRatio", 16.0 / 9}, {"yfov", 0.42}, {"znear", 0.1}}}});
  const double middle = 0.5 * boards * storey;
  file.add_node({{"name", "camera"},
                 {"camera", camera},
                 {"matrix", looking({0.7, middle + 0.35, 3.6}, {0, middle - 0.03, 0})}});
  file.write_glb(folder, "pottery");
}

}  // namespace tessera::generate
