#include "scenes/generate/noise.hpp"

#include <cmath>

namespace tessera::generate {

namespace {

double blend(double a, double b, double t) { return a + (b - a) * t; }

}  // namespace

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

Point unit(const Point& v) {
  const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  return {v[0] / length, v[1] / length, v[2] / length};
}

std::array<double, 2> on_circle(double turns) {
  const double quarters = 4 * turns, nearest = std::floor(quarters + 0.5);
  const double x = (quarters - nearest) * 1.5707963267948966, square = x * x;
  // Taylor's series, to an eighth of a turn.
  double cosine = 1, sine = 1;
  for (int n = 16; n > 0; n -= 2) {
    cosine = 1 - square / (n * (n - 1)) * cosine;
    sine = 1 - square / (n * (n + 1)) * sine;
  }
  sine *= x;
  switch (static_cast<std::int64_t>(nearest) & 3) {
    case 0:
      return {cosine, sine};
    case 1:
      return {-sine, cosine};
    case 2:
      return {-cosine, -sine};
    default:
      return {sine, -cosine};
  }
}

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

}  // namespace tessera::generate
