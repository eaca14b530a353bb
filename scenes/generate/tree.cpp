#include "scenes/generate/tree.hpp"

#include <algorithm>

namespace tessera::generate {

namespace {

/// 0…1, of a tree's own.
double chance(int seed, int what) { return 0.5 + 0.5 * lattice(seed, what, 7001); }

/// The direction at part `t` (0…1) of the way around, in the plane y = 0: along a square, so that
/// it takes no sine.
Point around(double t) {
  const double way = 4 * t;
  const int side = static_cast<int>(way) % 4;
  const double along = 2 * (way - static_cast<int>(way)) - 1;
  switch (side) {
    case 0:
      return unit({1, 0, along});
    case 1:
      return unit({-along, 0, 1});
    case 2:
      return unit({-1, 0, -along});
    default:
      return unit({along, 0, -1});
  }
}

std::uint32_t add(Solid& solid, double x, double y, double z) {
  solid.positions.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
  return static_cast<std::uint32_t>(solid.positions.size() - 1);
}

void add_trunk(Solid& solid, double radius, double height) {
  constexpr int sides = 6;
  const std::uint32_t top = add(solid, 0, height, 0);
  for (int k = 0; k < sides; ++k) {
    const Point d = around(static_cast<double>(k) / sides);
    (void)add(solid, radius * d[0], -0.5, radius * d[2]);
  }
  for (std::uint32_t k = 0; k < sides; ++k)
    solid.indices.insert(solid.indices.end(), {top, top + 1 + (k + 1) % sides, top + 1 + k});
}

/// A cone whose rim is cut into `points` tips, hanging a little.
void add_branches(Solid& solid, int seed, double low, double high, double radius, int points) {
  const std::uint32_t top = add(solid, 0, high, 0);
  const int corners = 2 * points;
  for (int k = 0; k < corners; ++k) {
    const double uneven = 1 + 0.18 * lattice(seed, k, 7002);
    const double r = radius * uneven * (k % 2 == 0 ? 1.0 : 0.62);
    const Point d = around(static_cast<double>(k) / corners);
    (void)add(solid, r * d[0], low + (k % 2 == 0 ? -0.12 : 0.1) * radius, r * d[2]);
  }
  const auto count = static_cast<std::uint32_t>(corners);
  for (std::uint32_t k = 0; k < count; ++k)
    solid.indices.insert(solid.indices.end(), {top, top + 1 + (k + 1) % count, top + 1 + k});
}

}  // namespace

Tree conifer(int seed) {
  Tree out;
  const double height = 8 + 6 * chance(seed, 0), radius = height * (0.17 + 0.07 * chance(seed, 1));
  const int layers = 6 + static_cast<int>(3 * chance(seed, 2));
  add_trunk(out.wood, 0.02 * height, 0.9 * height);
  const double first = 0.1 + 0.06 * chance(seed, 3);
  for (int layer = 0; layer < layers; ++layer) {
    const double from = first + (1 - first) * layer / layers;
    const double to = std::min(1.0, from + 2.1 * (1 - first) / layers);
    add_branches(out.leaves, seed * 31 + layer, from * height, to * height, radius * (1.02 - from),
                 7 + layer % 3);
  }
  return out;
}

Tree broadleaf(int seed) {
  Tree out;
  const double height = 6 + 5 * chance(seed, 4), radius = height * (0.26 + 0.08 * chance(seed, 5));
  add_trunk(out.wood, 0.028 * height, 0.7 * height);
  constexpr std::size_t squares = 10;
  for (int side = 0; side < 6; ++side)
    for (std::size_t j = 0; j <= squares; ++j)
      for (std::size_t i = 0; i <= squares; ++i) {
        const Point d = unit(on_cube(side, i, j, squares));
        const double shift = 17.3 * seed;
        const double lump = noise({2.1 * d[0] + shift, 2.1 * d[1], 2.1 * d[2]});
        const double leaf = noise({6.3 * d[0], 6.3 * d[1] + shift, 6.3 * d[2]});
        const double r = radius * (1 + 0.3 * lump + 0.24 * leaf);
        (void)add(out.leaves, r * d[0], height - radius + 1.05 * r * d[1], r * d[2]);
      }
  for (std::uint32_t side = 0; side < 6; ++side)
    for (std::uint32_t j = 0; j < squares; ++j)
      for (std::uint32_t i = 0; i < squares; ++i) {
        constexpr std::uint32_t row = squares + 1;
        const std::uint32_t a = side * row * row + j * row + i;
        out.leaves.indices.insert(out.leaves.indices.end(),
                                  {a, a + 1, a + row + 1, a, a + row + 1, a + row});
      }
  return out;
}

}  // namespace tessera::generate
