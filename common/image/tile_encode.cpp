#include <cassert>
#include <cstring>

#include "common/image/exr_layout.hpp"
#include "common/image/tile.hpp"
#include "common/image/tile_layout.hpp"

namespace tessera::image {

std::vector<std::byte> encode_tile(const TileImage& tile) {
  assert(tile.values.size() == tile.channels() * tile.pixels());
  const ChannelLayout& channels = *tile.layout;
  const std::span<const std::size_t> order = channels.by_name(tile.has_aovs());
  ExrLayout layout{.data = tile.window,
                   .film_width = tile.film_width,
                   .film_height = tile.film_height,
                   .channels = {}};
  for (const std::size_t channel : order) layout.channels.push_back(channels[channel].name);
  std::vector<Metadata::Attribute> attributes;
  for (std::size_t group = 0; group < group_count; ++group)
    attributes.push_back(
        {std::string(samples_attribute[group]), static_cast<std::int32_t>(tile.samples[group])});

  std::vector<std::byte> out = exr_header(layout, attributes);
  const auto lines = static_cast<std::size_t>(tile.window.height);
  const std::size_t row_bytes = static_cast<std::size_t>(tile.window.width) * sizeof(float);
  const std::size_t chunk_bytes = 2 * sizeof(std::int32_t) + layout.line_bytes();
  std::size_t table = out.size();
  const std::size_t first_chunk = table + lines * sizeof(std::uint64_t);
  out.resize(first_chunk + lines * chunk_bytes);
  std::byte* at = out.data() + first_chunk;
  for (std::size_t line = 0; line < lines; ++line) {
    const std::uint64_t offset = first_chunk + line * chunk_bytes;
    std::memcpy(out.data() + table, &offset, sizeof offset);
    table += sizeof offset;
    const std::array<std::int32_t, 2> leader{tile.window.y + static_cast<std::int32_t>(line),
                                             static_cast<std::int32_t>(layout.line_bytes())};
    std::memcpy(at, leader.data(), sizeof leader);
    at += sizeof leader;
    for (const std::size_t channel : order) {
      std::memcpy(at,
                  tile.plane(channel).data() + line * static_cast<std::size_t>(tile.window.width),
                  row_bytes);
      at += row_bytes;
    }
  }
  return out;
}

}  // namespace tessera::image
