#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>

#include "server/film/film.hpp"

namespace tessera::server {

namespace {

constexpr std::size_t rgba_channels = 4;
static_assert(image::A + 1 == rgba_channels);

std::size_t pixels_of(const TileGrid& grid) {
  return static_cast<std::size_t>(grid.window().pixels());
}

/// The first `channels` planes.
std::vector<float> resolve_channels(const FilmSnapshot& film, std::size_t channels) {
  std::vector<float> planes(channels * pixels_of(film.grid));
  const FilmRows rows(film);
  std::span<float> rest(planes);
  const auto width = static_cast<std::size_t>(rows.width());
  for (std::size_t channel = 0; channel < channels; ++channel) {
    for (int y = 0; y < rows.height(); ++y) {
      rows.values(channel, y, rest.first(width));
      rest = rest.subspan(width);
    }
  }
  return planes;
}

/// IEEE half, to the nearest even; what is beyond its range becomes its largest, so that no picture
/// shows Inf.
std::uint16_t half_of(float value) {
  constexpr float largest = 65504;
  const __m128 clamped = _mm_set_ss(std::clamp(value, -largest, largest));
  return static_cast<std::uint16_t>(
      _mm_extract_epi16(_mm_cvtps_ph(clamped, _MM_FROUND_TO_NEAREST_INT), 0));
}

void append(std::vector<std::byte>& out, const void* from, std::size_t size) {
  const auto* bytes = static_cast<const std::byte*>(from);
  out.insert(out.end(), bytes, bytes + size);
}

void append_tile(std::vector<std::byte>& out, const FilmTile& tile) {
  const std::size_t pixels = tile.pixels();
  std::vector<std::uint16_t> halves(rgba_channels * pixels);
  std::vector<float> plane(pixels);
  for (std::size_t c = 0; c < rgba_channels; ++c) {
    read_values(tile, c, 0, plane);
    for (std::size_t i = 0; i < pixels; ++i) halves[rgba_channels * i + c] = half_of(plane[i]);
  }
  append(out, halves.data(), halves.size() * sizeof(std::uint16_t));
}

}  // namespace

void FilmRows::values(std::size_t channel, int y, std::span<float> row) const {
  each_tile(y, [&](const FilmTile* tile, const Rect& window) {
    float* to = row.data() + (window.x - film_.grid.window().x);
    if (!tile) {
      const bool nearest = layout()[channel].merge == image::Merge::nearest;
      std::fill_n(to, window.width, nearest ? image::nothing_hit_z : 0.0F);
      return;
    }
    const auto width = static_cast<std::size_t>(window.width);
    const auto above = static_cast<std::size_t>(y + film_.grid.window().y - window.y);
    read_values(*tile, channel, above * width, {to, width});
  });
}

void FilmRows::samples(int y, std::span<std::uint32_t> row) const {
  each_tile(y, [&](const FilmTile* tile, const Rect& window) {
    const std::uint64_t n =
        tile ? tile->samples[static_cast<std::size_t>(image::Group::beauty)] : 0;
    std::fill_n(row.data() + (window.x - film_.grid.window().x), window.width,
                static_cast<std::uint32_t>(n));
  });
}

template <class Visit>
void FilmRows::each_tile(int y, Visit visit) const {
  const TileGrid& grid = film_.grid;
  const int first = grid.row_of(grid.window().y + y) * grid.columns();
  for (int index = first; index < first + grid.columns(); ++index) {
    const auto tile = static_cast<std::uint32_t>(index);
    visit(film_.tiles[tile].get(), grid.tile(tile));
  }
}

image::FrameImage resolve(const FilmSnapshot& film) {
  const FilmRows rows(film);
  image::FrameImage frame{.width = rows.width(),
                          .height = rows.height(),
                          .values = {},
                          .samples = {},
                          .layout = film.layout};
  frame.values = resolve_channels(film, film.layout->size());
  frame.samples.resize(frame.pixels());
  const auto width = static_cast<std::size_t>(frame.width);
  for (int y = 0; y < frame.height; ++y)
    rows.samples(y, std::span(frame.samples).subspan(static_cast<std::size_t>(y) * width, width));
  return frame;
}

std::vector<float> resolve_rgba(const FilmSnapshot& film) {
  return resolve_channels(film, rgba_channels);
}

std::vector<std::uint32_t> changed_since(const FilmSnapshot& film, std::uint64_t since) {
  // Who knows a later version than there is knew another film: all of this one is new to him.
  const std::uint64_t known = since > film.version ? 0 : since;
  std::vector<std::uint32_t> changed;
  for (std::size_t i = 0; i < film.tiles.size(); ++i)
    if (film.tiles[i] && film.versions[i] > known) changed.push_back(static_cast<std::uint32_t>(i));
  return changed;
}

std::vector<std::byte> encode_changed_tiles(const FilmSnapshot& film, std::uint64_t since) {
  constexpr std::string_view magic = "TSRT";
  constexpr std::size_t alignment = 8;
  const std::vector<std::uint32_t> changed = changed_since(film, since);
  nlohmann::ordered_json header{{"version", film.version},
                                {"width", film.grid.film_width()},
                                {"height", film.grid.film_height()}};
  auto& tiles = header["tiles"] = nlohmann::ordered_json::array();
  std::size_t pixels = 0;
  for (const std::uint32_t index : changed) {
    const Rect& window = film.tiles[index]->window;
    tiles.push_back(
        {{"x", window.x}, {"y", window.y}, {"width", window.width}, {"height", window.height}});
    pixels += film.tiles[index]->pixels();
  }
  std::string text = header.dump();
  text.resize((text.size() + alignment - 1) / alignment * alignment, ' ');

  std::vector<std::byte> out;
  out.reserve(8 + text.size() + pixels * rgba_channels * sizeof(std::uint16_t));
  append(out, magic.data(), magic.size());
  const auto length = static_cast<std::uint32_t>(text.size());
  append(out, &length, sizeof length);
  append(out, text.data(), text.size());
  for (const std::uint32_t index : changed) append_tile(out, *film.tiles[index]);
  return out;
}

}  // namespace tessera::server
