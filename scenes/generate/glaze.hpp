#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera::generate {

/// Pictures of one pot's surface, `side` by `side` texels of R, G, B in 8 bits, as glTF's materials
/// take them. The left edge goes on at the right.
struct Glaze {
  std::vector<std::uint8_t> base_color;
  std::vector<std::uint8_t> normal;
  std::vector<std::uint8_t> metallic_roughness;
};

/// Clay, and over it from the lip down to a ragged line a glaze with spots, bands and a fine
/// crackle; a band of gold on some. Each of the kinds has its own colours.
Glaze glaze(int kind, std::size_t side);

}  // namespace tessera::generate
