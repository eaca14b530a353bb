#pragma once
#include <cstdint>
#include <random>

#include "common/image/tile.hpp"

namespace tessera::image {

/// A tile of random but lawful values; equal arguments give equal tiles.
inline TileImage make_tile(Rect window, int film_width, int film_height, std::uint32_t samples,
                           bool aovs, unsigned seed = 1) {
  TileImage tile{.window = window,
                 .film_width = film_width,
                 .film_height = film_height,
                 .samples = {samples, aovs ? samples : 0},
                 .values = {}};
  tile.values.resize(tile.channels() * tile.pixels());
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, 4);
  for (float& value : tile.values) value = uniform(random);
  return tile;
}

inline TileExpectation expectation_of(const TileImage& tile) {
  return {.window = tile.window,
          .film_width = tile.film_width,
          .film_height = tile.film_height,
          .samples = tile.samples[0],
          .aovs = tile.has_aovs()};
}

}  // namespace tessera::image
