#pragma once
#include "common/image/tile_view.hpp"
#include "server/film/film_tile.hpp"

namespace tessera::server {

/// Folds a pass's Cryptomattes in, pixel by pixel: weights of equal ids are summed, the heaviest
/// are kept, and what has no slot is counted.
void fold_mattes(FilmTile& tile, const image::TileView& pass);

}  // namespace tessera::server
