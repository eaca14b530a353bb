#pragma once
#include <array>
#include <cstdint>
#include <vector>

namespace tessera::generate {

constexpr int pot_kinds = 24;

/// A pot in metres, standing on the origin, y up: a closed surface from the foot's rim up the outer
/// wall, over the lip and down inside.
struct Pot {
  std::vector<std::array<float, 3>> positions, normals;
  std::vector<std::array<float, 4>> tangents;  ///< as glTF has them
  std::vector<std::array<float, 2>> uvs;       ///< u once around, v from the inside's end down
  std::vector<std::uint32_t> indices;
};

/// Kind `kind` (0…23), `around` · `along` squares of two triangles each, all different: thrown on
/// a wheel, dented, some fluted.
Pot pot(int kind, std::size_t around, std::size_t along);
/// Width of its widest part, metres.
double pot_width(int kind);

}  // namespace tessera::generate
