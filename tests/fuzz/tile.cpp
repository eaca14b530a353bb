// A worker's result, as the coordinator reads it: a tile of 4 by 3 pixels, with AOVs or without.
#include <algorithm>
#include <cmath>

#include "common/image/tile.hpp"
#include "common/image/tile_view.hpp"
#include "tests/fuzz/target.hpp"

namespace {

using namespace tessera;

void read(std::span<const std::byte> exr, bool aovs) {
  const image::TileExpectation expected{.window = {.x = 8, .y = 4, .width = 4, .height = 3},
                                        .film_width = 40,
                                        .film_height = 30,
                                        .samples = 3,
                                        .aovs = aovs};
  fuzz::take_or_refuse([&] {
    const image::TileImage tile = image::decode_tile(exr, expected);
    fuzz::require(tile.window == expected.window, "a tile has the window of its task");
    fuzz::require(std::all_of(tile.values.begin(), tile.values.end(),
                              [](float value) { return std::isfinite(value); }),
                  "a tile's values are finite");
    const image::TileView view = image::view_tile(exr, expected);
    for (std::size_t channel = 0; channel < view.channels(); ++channel)
      for (std::size_t y = 0; y < view.lines.size(); ++y)
        for (std::size_t x = 0; x < view.row(channel, y).size(); ++x)
          fuzz::require(
              view.row(channel, y)[x] == tile.plane(channel)[y * view.row(channel, y).size() + x],
              "a tile has the same values where they stand and as a copy");
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  read(fuzz::bytes_of(data, size), false);
  read(fuzz::bytes_of(data, size), true);
  return 0;
}
