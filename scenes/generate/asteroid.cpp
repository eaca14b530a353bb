#include "scenes/generate/asteroid.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <memory>

#include "common/base/error.hpp"
#include "common/base/files.hpp"

namespace tessera::generate {

namespace {

/// A value for a whole point, −1…1 (the finaliser of MurmurHash3 over its coordinates).
double lattice(std::int64_t x, std::int64_t y, std::int64_t z) {
  std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15ULL;
  h = (h ^ static_cast<std::uint64_t>(y)) * 0xbf58476d1ce4e5b9ULL;
  h = (h ^ static_cast<std::uint64_t>(z)) * 0x94d049bb133111ebULL;
  h ^= h >> 33;
  h *= 0xff51afd7ed558ccdULL;
  h ^= h >> 33;
  h *= 0xc4ceb9fe1a85ec53ULL;
  h ^= h >> 33;
  return static_cast<double>(h >> 11) * 0x1p-52 - 1;
}

double blend(double a, double b, double t) { return a + (b - a) * t; }

Point unit(const Point& v) {
  const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  return {v[0] / length, v[1] / length, v[2] / length};
}

/// Point (i, j) of side `side` of the cube [−1, 1]³, n squares along an edge, counter-clockwise
/// seen from outside.
Point on_cube(int side, std::size_t i, std::size_t j, std::size_t n) {
  const double u = 2.0 * static_cast<double>(i) / static_cast<double>(n) - 1;
  const double v = 2.0 * static_cast<double>(j) / static_cast<double>(n) - 1;
  switch (side) {
    case 0:
      return {1, u, v};
    case 1:
      return {-1, v, u};
    case 2:
      return {v, 1, u};
    case 3:
      return {u, -1, v};
    case 4:
      return {u, v, 1};
    default:
      return {v, u, -1};
  }
}

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

double noise(const Point& p) {
  std::array<std::int64_t, 3> cell{};
  Point t{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double whole = std::floor(p[axis]);
    cell[axis] = static_cast<std::int64_t>(whole);
    const double f = p[axis] - whole;
    t[axis] = f * f * f *
              (f * (f * 6 - 15) + 10);  // Perlin's fade: first and second derivative are continuous
  }
  const auto along_x = [&](std::int64_t y, std::int64_t z) {
    return blend(lattice(cell[0], y, z), lattice(cell[0] + 1, y, z), t[0]);
  };
  const auto in_plane = [&](std::int64_t z) {
    return blend(along_x(cell[1], z), along_x(cell[1] + 1, z), t[1]);
  };
  return blend(in_plane(cell[2]), in_plane(cell[2] + 1), t[2]);
}

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
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw Error(ErrorKind::failed,
                fmt::format("{} cannot be made: {}", folder.string(), error.message()));
  write_rock(folder / "asteroid.obj", grid_side(triangles));
  write_file_atomically(folder / "asteroid.json", std::string_view(scene_text));
}

}  // namespace tessera::generate
