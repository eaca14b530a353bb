#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/image/channels.hpp"
#include "common/image/tile.hpp"
#include "common/image/tile_view.hpp"
#include "common/job/tile_grid.hpp"

/// Folding: what a tile of the film has gathered, exactly. Pure.
namespace tessera::server {

/// One tile of a film after some passes. Sums are double, folded in pass order; nothing is rounded
/// until it is read.
struct FilmTile {
  Rect window;
  std::uint32_t passes = 0;                                 ///< folded: [0, passes)
  std::array<std::uint64_t, image::group_count> samples{};  ///< per pixel, of each group
  /// Planes in the order of the layout: Σ n·mean for means, M2 for second moments, the least
  /// for nearest, all else as in a tile's passes.
  std::vector<double> sums;
  image::Layout layout = image::default_layout();

  [[nodiscard]] std::size_t pixels() const { return static_cast<std::size_t>(window.pixels()); }
};

/// Nothing gathered yet.
FilmTile empty_film_tile(const Rect& window, image::Layout layout = image::default_layout());
/// Folds the result of pass `tile.passes` in. Passes must come in order, each once.
void fold(FilmTile& tile, const image::TileView& pass);
void fold(FilmTile& tile, const image::TileImage& pass);
/// What a picture shows of a channel in the tile's pixels from `first` on: means, M2, nearest;
/// alpha with the shadows that were caught (caught_shadow.hpp). Where a group has no samples, 0 (Z:
/// nothing_hit_z).
void read_values(const FilmTile& tile, std::size_t channel, std::size_t first,
                 std::span<float> out);
/// All of them, of all channels; planes as in TileImage.
std::vector<float> resolve(const FilmTile& tile);
/// What a channel's sums are divided by to give its values: its group's samples for means and
/// weights of mattes, 1 for all else.
double mean_divisor(const FilmTile& tile, std::size_t channel);

}  // namespace tessera::server
