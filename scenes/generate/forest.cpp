#include "scenes/generate/forest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/files.hpp"
#include "scenes/generate/folder.hpp"
#include "scenes/generate/gltf_file.hpp"
#include "scenes/generate/tree.hpp"

namespace tessera::generate {

namespace {

using nlohmann::json;

constexpr double spacing = 3.4;  // metres
constexpr int conifers = 12;     // of the kinds; the others are broadleaves

json primitive(GltfFile& file, const Solid& solid, int material) {
  const int positions = file.positions(solid.positions);
  const int indices = file.accessor(solid.indices, Target::indices);
  return {{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"material", material}};
}

int material(GltfFile& file, const std::string& name, const std::array<double, 3>& color,
             double roughness) {
  return file.add("materials", {{"name", name},
                                {"doubleSided", true},
                                {"pbrMetallicRoughness",
                                 {{"baseColorFactor", {color[0], color[1], color[2], 1.0}},
                                  {"metallicFactor", 0},
                                  {"roughnessFactor", roughness}}}});
}

/// Where the trees of one kind stand.
struct Places {
  std::vector<std::array<float, 3>> translations, scales;
  std::vector<std::array<std::int16_t, 4>> rotations;
};

bool is_clearing(double x, double z) { return noise({x * 0.011, 40, z * 0.011}) > 0.24; }

std::size_t kind_at(double x, double z, std::int64_t i, std::int64_t k) {
  const double mixture = noise({x * 0.017, 80, z * 0.017}) + 0.35 * lattice(i, k, 7010);
  const double which = 0.5 + 0.5 * lattice(i, k, 7011);
  const std::size_t first = mixture > 0.12 ? conifers : 0;
  const std::size_t count = mixture > 0.12 ? forest_kinds - conifers : conifers;
  return first + std::min(static_cast<std::size_t>(which * static_cast<double>(count)), count - 1);
}

void stand(Places& places, double x, double z, std::int64_t i, std::int64_t k) {
  places.translations.push_back(
      {static_cast<float>(x), static_cast<float>(ground_height(x, z)), static_cast<float>(z)});
  const auto scale = static_cast<float>(1 + 0.32 * lattice(i, k, 7012));
  places.scales.push_back({scale, scale, scale});
  // Any unit vector (y, w) is a turn about y.
  const Point turn = unit({lattice(i, k, 7013), lattice(i, k, 7014) + 1e-9, 0});
  const auto part = [](double value) { return static_cast<std::int16_t>(value * 32767); };
  places.rotations.push_back({0, part(turn[0]), 0, part(turn[1])});
}

/// On a jittered grid of side × side cells, but for the clearings.
std::vector<Places> places_of(std::int64_t side) {
  std::vector<Places> out(forest_kinds);
  for (std::int64_t k = 0; k < side; ++k)
    for (std::int64_t i = 0; i < side; ++i) {
      const double half = 0.5 * static_cast<double>(side);
      const double x = spacing * (static_cast<double>(i) - half + 0.42 * lattice(i, k, 7015));
      const double z = spacing * (static_cast<double>(k) - half + 0.42 * lattice(i, k, 7016));
      if (!is_clearing(x, z)) stand(out[kind_at(x, z, i, k)], x, z, i, k);
    }
  return out;
}

std::size_t count(const std::vector<Places>& kinds) {
  std::size_t sum = 0;
  for (const Places& places : kinds) sum += places.translations.size();
  return sum;
}

Solid ground(double extent) {
  constexpr std::uint32_t squares = 400;
  Solid out;
  for (std::uint32_t k = 0; k <= squares; ++k)
    for (std::uint32_t i = 0; i <= squares; ++i) {
      const double x = extent * (static_cast<double>(i) / squares - 0.5);
      const double z = extent * (static_cast<double>(k) / squares - 0.5);
      out.positions.push_back(
          {static_cast<float>(x), static_cast<float>(ground_height(x, z)), static_cast<float>(z)});
    }
  for (std::uint32_t k = 0; k < squares; ++k)
    for (std::uint32_t i = 0; i < squares; ++i) {
      const std::uint32_t a = k * (squares + 1) + i, b = a + squares + 1;
      out.indices.insert(out.indices.end(), {a, b, b + 1, a, b + 1, a + 1});
    }
  return out;
}

std::string scene_text(double extent) {
  const double z = 0.32 * extent, eye = ground_height(0, z) + 26;
  return fmt::format(R"({{
  "tessera": 1,
  "name": "Forest",
  "about": "Made by tessera-scenes: a few trees that stand at very many places.",
  "include": ["forest.gltf"],
  "film": {{"width": 960, "height": 540}},
  "render": {{"samples": 64, "bounces": 4}},
  "camera": {{"eye": [0, {:.3f}, {:.3f}], "target": [0, {:.3f}, {:.3f}], "fov": 38}},
  "environment": {{"radiance": [0.34, 0.47, 0.7]}},
  "lights": [
    {{"type": "directional", "direction": [-0.8, -0.42, 0.35], "irradiance": [4.6, 3.5, 2.2]}}
  ]
}}
)",
                     eye, z, eye - 17, z - 100);
}

}  // namespace

double ground_height(double x, double z) {
  return 26 * noise({x * 0.0045, 3, z * 0.0045}) + 5 * noise({x * 0.021, 9, z * 0.021});
}

void write_forest(const std::filesystem::path& folder, std::size_t trees) {
  make_folder(folder);
  auto side = static_cast<std::int64_t>(std::ceil(std::sqrt(static_cast<double>(trees))));
  std::vector<Places> places = places_of(side);
  while (count(places) < trees) {
    side += side / 32 + 1;
    places = places_of(side);
  }
  GltfFile file("forest");
  file.use_extension("EXT_mesh_gpu_instancing");
  const int bark = material(file, "bark", {0.17, 0.11, 0.07}, 0.9);
  const int grass = material(file, "grass", {0.19, 0.24, 0.07}, 1);
  const double extent = spacing * static_cast<double>(side) + 40;
  file.place("ground", json::array({primitive(file, ground(extent), grass)}), json::object());
  for (std::size_t kind = 0; kind < forest_kinds; ++kind) {
    const bool needles = kind < conifers;
    const auto seed = static_cast<int>(kind);
    const double warm = 0.5 + 0.5 * lattice(seed, 0, 7020), light = 0.85 + 0.3 * warm;
    const std::string name = fmt::format("{} {}", needles ? "conifer" : "broadleaf", kind + 1);
    const int leaves = needles
                           ? material(file, name, {0.05 * light, 0.11 * light, 0.04}, 0.8)
                           : material(file, name, {0.06 + 0.16 * warm * warm, 0.15, 0.035}, 0.8);
    const Tree tree = needles ? conifer(seed) : broadleaf(seed);
    const Places& its = places[kind];
    if (its.translations.empty()) continue;
    const int translation = file.accessor(its.translations, Target::other);
    const int rotation = file.accessor(its.rotations, Target::other, true);
    const int scale = file.accessor(its.scales, Target::other);
    const json copies{{"TRANSLATION", translation}, {"ROTATION", rotation}, {"SCALE", scale}};
    file.place(
        name, json::array({primitive(file, tree.wood, bark), primitive(file, tree.leaves, leaves)}),
        {{"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", copies}}}}}});
  }
  file.write_gltf(folder, "forest");
  write_file_atomically(folder / "forest.json", std::string_view(scene_text(extent)));
}

}  // namespace tessera::generate
