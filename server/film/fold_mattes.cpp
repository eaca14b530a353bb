#include "server/film/fold_mattes.hpp"

#include <array>

#include "common/job/matte_pixel.hpp"

namespace tessera::server {

namespace {

void fold_matte(FilmTile& tile, const image::TileView& pass, std::size_t first) {
  const auto width = static_cast<std::size_t>(tile.window.width);
  MattePixel pixel;
  std::array<double, matte_channels> folded{}, arrived{};
  for (std::size_t i = 0; i < tile.pixels(); ++i) {
    for (std::size_t c = 0; c < matte_channels; ++c) {
      folded[c] = tile.sums[(first + c) * tile.pixels() + i];
      arrived[c] = static_cast<double>(pass.row(first + c, i / width)[i % width]);
    }
    pixel.clear();
    pixel.add(folded);
    pixel.add(arrived);
    pixel.write(folded);
    for (std::size_t c = 0; c < matte_channels; ++c)
      tile.sums[(first + c) * tile.pixels() + i] = folded[c];
  }
}

}  // namespace

void fold_mattes(FilmTile& tile, const image::TileView& pass) {
  if (!pass.has_aovs()) return;
  for (const image::AovPlanes& aov : tile.layout->aovs())
    if ((*tile.layout)[aov.first].merge == Merge::matte) fold_matte(tile, pass, aov.first);
}

}  // namespace tessera::server
