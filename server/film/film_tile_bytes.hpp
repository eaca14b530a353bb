#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "server/film/film_tile.hpp"

/// A film's tile as bytes: exact. Pure.
namespace tessera::server {

/// Little-endian: u32 version, i32 x, y, width, height, u32 passes, u32 groups, u64 samples of
/// each, u32 channels; then for each channel u8 k and the upper k bytes of every sum. The lower
/// ones are all 0: sums of a few floats seldom need all of a double.
std::vector<std::byte> bytes_of(const FilmTile& tile);
/// Throws Error{failed} if the bytes are no tile of this window and layout.
FilmTile film_tile_from(std::span<const std::byte> bytes, const Rect& window, image::Layout layout);

/// Memory of a film's sums, bytes.
inline std::size_t film_bytes(std::int64_t pixels, const image::ChannelLayout& layout) {
  return static_cast<std::size_t>(pixels) * layout.size() * sizeof(double);
}

}  // namespace tessera::server
