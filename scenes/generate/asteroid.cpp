#include "scenes/generate/asteroid.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <memory>

#include "common/base/error.hpp"
#include "common/base/files.hpp"
#include "scenes/generate/folder.hpp"
#include "scenes/generate/noise.hpp"

namespace tessera::generate {

namespace {

/// Writes text to a file in large pieces.
class Writer {
 public:
  explicit Writer(std::filesystem::path path)
      : path_(std::move(path)), file_(std::fopen(path_.c_str(), "wb"), std::fclose) {
    if (!file_) fail();
  }
  template <class... Args>
  void line(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(buffer_), format, std::forward<Args>(args)...);
    if (buffer_.size() > (std::size_t{1} << 20)) flush();
  }
  void finish() {
    flush();
    std::FILE* const file = file_.release();
    if (std::fclose(file) != 0) fail();
  }

 private:
  [[noreturn]] void fail() const {
    throw Error(ErrorKind::failed, fmt::format("{} cannot be written", path_.string()));
  }
  void flush() {
    if (std::fwrite(buffer_.data(), 1, buffer_.size(), file_.get()) != buffer_.size()) fail();
    buffer_.clear();
  }
  std::filesystem::path path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  fmt::memory_buffer buffer_;
};

void write_rock(const std::filesystem::path& file, std::size_t n) {
  Writer out(file);
  out.line("# A rock of {} triangles, made by tessera-scenes\n", 12 * n * n);
  for (int side = 0; side < 6; ++side)
    for (std::size_t j = 0; j <= n; ++j)
      for (std::size_t i = 0; i <= n; ++i) {
        const Point d = unit(on_cube(side, i, j, n));
        const double r = rock_radius(d);
        out.line("v {:.7f} {:.7f} {:.7f}\n", d[0] * r, d[1] * r, d[2] * r);
      }
  for (std::size_t side = 0; side < 6; ++side)
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t a = 1 + side * (n + 1) * (n + 1) + j * (n + 1) + i;  // OBJ counts from 1
        const std::size_t b = a + 1, c = a + n + 2, d = a + n + 1;
        out.line("f {} {} {}\nf {} {} {}\n", a, b, c, a, c, d);
      }
  out.finish();
}

constexpr const char* scene_text = R"({
  "tessera": 1,
  "name": "Asteroid",
  "about": "Made by tessera-scenes: a rock of very many triangles.",
  "film": {"width": 960, "height": 540},
  "render": {"samples": 64, "bounces": 4},
  "camera": {"eye": [0, 1.2, 5], "target": [0, -0.05, 0], "fov": 32},
  "environment": {"radiance": [0.06, 0.08, 0.12]},
  "materials": {
    "stone": {"type": "diffuse", "reflectance": [0.55, 0.47, 0.4]},
    "floor": {"type": "diffuse", "reflectance": 0.35},
    "warm": {"type": "emitter", "radiance": [14, 10, 6]},
    "cold": {"type": "emitter", "radiance": [2, 4, 8]}
  },
  "shapes": [
    {"name": "rock", "type": "mesh", "material": "stone", "file": "asteroid.obj"},
    {"name": "floor", "type": "quad", "material": "floor", "corner": [-20, -1.4, 20], "edge_u": [40, 0, 0], "edge_v": [0, 0, -40]},
    {"name": "key", "type": "quad", "material": "warm", "corner": [2.2, 2.6, 2.2], "edge_u": [0.9, -0.9, 0], "edge_v": [-0.6, -0.6, 0.9],
     "transform": [{"translate": [0, 0.4, 0]}]},
    {"name": "rim", "type": "sphere", "material": "cold", "center": [-3, 1.5, -2], "radius": 0.5}
  ]
}
)";

}  // namespace

double rock_radius(const Point& direction) {
  const Point d = unit(direction);
  double sum = 0, scale = 1.7, height = 0.14;
  for (int octave = 0; octave < 9; ++octave) {
    // Each scale looks elsewhere, so that they have no common lattice point.
    const double shift = 19.3 * (octave + 1);
    sum += height * noise({d[0] * scale + shift, d[1] * scale + shift, d[2] * scale + shift});
    scale *= 2.05;
    height *= 0.5;
  }
  return 1 + sum;
}

std::size_t grid_side(std::size_t triangles) {
  std::size_t n = 1;
  while (12 * n * n < triangles) ++n;
  return n;
}

void write_asteroid(const std::filesystem::path& folder, std::size_t triangles) {
  make_folder(folder);
  write_rock(folder / "asteroid.obj", grid_side(triangles));
  write_file_atomically(folder / "asteroid.json", std::string_view(scene_text));
}

}  // namespace tessera::generate
