#pragma once
#include <cstddef>
#include <optional>
#include <span>

#include "server/film/film_tile.hpp"

/// Shadow catchers in a picture: alpha that is made of what was caught. Pure.
namespace tessera::server {

/// Where the channels of Aov::shadow_catcher begin in a layout; nothing: it has none.
std::optional<std::size_t> first_caught(const image::ChannelLayout& layout);

/// What a picture shows as alpha in the tile's pixels from `first` on: that of what is seen, and of
/// the black that catchers hold, coverage · (1 − Y(shadowed) / Y(unshadowed)). Y is the luminance
/// by Rec. 709, and the ratio within 0…1, 1 where nothing lights the catcher. `caught` is
/// first_caught(). In double, rounded once; at most 1.
void read_alpha(const FilmTile& tile, std::size_t caught, std::size_t first, std::span<float> out);

}  // namespace tessera::server
