#pragma once
#include <cstdint>
#include <vector>

#include "scenes/generate/noise.hpp"

namespace tessera::generate {

/// Triangles, in metres; the root is at the origin, and y is up.
struct Solid {
  std::vector<std::array<float, 3>> positions;
  std::vector<std::uint32_t> indices;
};

struct Tree {
  Solid wood, leaves;
};

/// Cones of branches, one above the other: 8 to 14 m high.
Tree conifer(int seed);
/// A crown that is a lump of leaves: 6 to 11 m high.
Tree broadleaf(int seed);

}  // namespace tessera::generate
