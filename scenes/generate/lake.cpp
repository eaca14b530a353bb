#include "scenes/generate/lake.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>

#include "common/base/files.hpp"
#include "scenes/generate/folder.hpp"
#include "scenes/generate/noise.hpp"

namespace tessera::generate {

namespace {

constexpr const char* head = R"({
  "tessera": 1,
  "name": "Lanterns on a lake",
  "about": "Made by tessera-scenes: very many small lamps over water at night.",
  "film": {"width": 960, "height": 540},
  "render": {"samples": 512, "bounces": 6},
  "camera": {"eye": [0, 2.6, 12], "target": [0, 5.2, -20], "fov": 42},
  "environment": {"radiance": [0.003, 0.005, 0.012]},
  "materials": {
    "water": {"type": "principled", "base_color": [0.004, 0.008, 0.012], "roughness": 0.12, "ior": 1.33},
    "wood": {"type": "diffuse", "reflectance": [0.36, 0.25, 0.16], "roughness": 0.5},
    "amber": {"type": "emitter", "radiance": [2.4, 0.9, 0.2]},
    "gold": {"type": "emitter", "radiance": [2.6, 1.25, 0.38]},
    "ember": {"type": "emitter", "radiance": [2.1, 0.62, 0.12]},
    "rose": {"type": "emitter", "radiance": [2.0, 0.7, 0.42]}
  },
  "shapes": [
    {"type": "quad", "material": "water", "corner": [-600, 0, 40], "edge_u": [1200, 0, 0], "edge_v": [0, 0, -1200]})";
constexpr std::array<const char*, 4> papers{"amber", "gold", "ember", "rose"};
/// Metres, before the camera.
constexpr double nearest = 5, farthest = 150;

/// Uniform in 0…1, of lantern i.
double number(std::size_t i, int which) {
  return 0.5 * (lattice(static_cast<std::int64_t>(i), which, 71) + 1);
}

/// Planks on posts, from below the camera out over the water.
void add_jetty(fmt::memory_buffer& out) {
  const auto box = [&](double x, double y, double z, double width, double height, double depth) {
    fmt::format_to(std::back_inserter(out),
                   ",\n    {{\"type\": \"box\", \"material\": \"wood\", \"low\": [{:.3f}, {:.3f}, "
                   "{:.3f}], \"high\": [{:.3f}, {:.3f}, {:.3f}]}}",
                   x, y, z, x + width, y + height, z + depth);
  };
  for (int plank = 0; plank < 34; ++plank) {
    const auto at = static_cast<std::size_t>(plank);
    const double left = -1 + 0.06 * number(at, 7), right = 1 + 0.06 * number(at, 8);
    box(left, 0.5 + 0.012 * number(at, 9), 8 - 0.26 * plank, right - left, 0.05, 0.245);
  }
  for (const double x : {-1.06, 0.98})
    for (int post = 0; post < 4; ++post)
      box(x, -0.5, 7.4 - 2.7 * post, 0.12, post == 3 ? 1.75 : 1.3, 0.12);
}

void add_lantern(fmt::memory_buffer& out, std::size_t i) {
  // As many at each distance, fewer the higher.
  const double depth = number(i, 0), up = number(i, 3);
  const double away = nearest + depth * (farthest - nearest);
  const double aside = (number(i, 1) - 0.5) * (16 + 1.8 * away);
  const bool afloat = number(i, 2) < 0.3;
  const double radius = 0.07 + 0.07 * number(i, 4);
  const double height = afloat ? 0.8 * radius : 1 + 0.62 * up * up * (8 + away);
  fmt::format_to(
      std::back_inserter(out),
      ",\n    {{\"type\": \"sphere\", \"material\": \"{}\", \"center\": [{:.3f}, {:.3f}, "
      "{:.3f}], \"radius\": {:.3f}}}",
      papers[static_cast<std::size_t>(number(i, 5) * 3.999)], aside, height, 6 - away, radius);
}

}  // namespace

void write_lake(const std::filesystem::path& folder, std::size_t lanterns) {
  make_folder(folder);
  fmt::memory_buffer out;
  out.append(std::string_view(head));
  add_jetty(out);
  for (std::size_t i = 0; i < lanterns; ++i) add_lantern(out, i);
  out.append(std::string_view("\n  ]\n}\n"));
  write_file_atomically(folder / "lake.json", std::string_view(out.data(), out.size()));
}

}  // namespace tessera::generate
