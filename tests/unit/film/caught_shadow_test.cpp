// Alpha of what shadow catchers caught: folded as means, made where a picture is read.
#include "server/film/caught_shadow.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <random>

#include "server/film/film.hpp"

namespace tessera::server {
namespace {

using image::Layout;
using image::TileImage;

const Layout& layout() {
  static const Layout with =
      image::layout_of(std::vector<std::string>{"Z", std::string(shadow_catcher_aov)});
  return with;
}
std::size_t caught() { return first_caught(*layout()).value(); }

/// What the samples of a pixel gave in the mean.
struct Seen {
  float alpha = 0, coverage = 0;
  std::array<float, 3> shadowed{}, unshadowed{};
};

/// A pass of `n` samples over `window`, all of whose pixels saw this.
TileImage pass_of(const Rect& window, std::uint32_t n, const Seen& seen) {
  TileImage tile{.window = window,
                 .film_width = 8,
                 .film_height = 6,
                 .samples = {n, 0},
                 .values = {},
                 .layout = layout()};
  tile.values.resize(tile.channels() * tile.pixels());
  std::ranges::fill(tile.plane(image::A), seen.alpha);
  std::ranges::fill(tile.plane(image::R), 0.125F);
  for (std::size_t c = 0; c < 3; ++c) {
    std::ranges::fill(tile.plane(caught() + caught_R + c), seen.shadowed.at(c));
    std::ranges::fill(tile.plane(caught() + unshadowed_R + c), seen.unshadowed.at(c));
  }
  std::ranges::fill(tile.plane(caught() + caught_coverage), seen.coverage);
  return tile;
}

constexpr Rect window{0, 0, 8, 6};

float alpha_of(const std::vector<std::pair<std::uint32_t, Seen>>& passes) {
  FilmTile film = empty_film_tile(window, layout());
  for (const auto& [n, seen] : passes) fold(film, pass_of(window, n, seen));
  return resolve(film)[image::A * film.pixels() + 11];
}
float alpha_of(const Seen& seen) { return alpha_of({{4, seen}}); }

TEST(CaughtShadow, is_the_part_of_the_light_that_is_lacking) {
  EXPECT_EQ(alpha_of(Seen{.coverage = 1, .shadowed = {1, 1, 1}, .unshadowed = {4, 4, 4}}), 0.75F);
  EXPECT_EQ(alpha_of(Seen{.coverage = 1, .shadowed = {}, .unshadowed = {1, 2, 3}}), 1);
  EXPECT_EQ(alpha_of(Seen{.coverage = 1, .shadowed = {1, 2, 3}, .unshadowed = {1, 2, 3}}), 0);
}

TEST(CaughtShadow, goes_by_luminance) {
  EXPECT_EQ(alpha_of(Seen{.coverage = 1, .shadowed = {1, 0, 0}, .unshadowed = {1, 1, 1}}),
            static_cast<float>(1 - 0.2126));
  EXPECT_EQ(alpha_of(Seen{.coverage = 1, .shadowed = {0, 0, 1}, .unshadowed = {1, 1, 1}}),
            static_cast<float>(1 - 0.0722));
}

TEST(CaughtShadow, lies_beside_what_is_seen) {
  const Seen half{.alpha = 0.5, .coverage = 0.25, .shadowed = {1, 1, 1}, .unshadowed = {2, 2, 2}};
  EXPECT_EQ(alpha_of(half), 0.625F);
  EXPECT_EQ(alpha_of(Seen{.alpha = 0.5}), 0.5F);
  // Rounded shares may come to more than all.
  EXPECT_EQ(alpha_of(Seen{.alpha = 0.75F, .coverage = 0.2500001F, .unshadowed = {1, 1, 1}}), 1);
}

TEST(CaughtShadow, is_none_where_nothing_lights_the_catcher_or_more_is_lit_than_there_is) {
  EXPECT_EQ(alpha_of(Seen{.coverage = 1}), 0);
  EXPECT_EQ(alpha_of(Seen{.coverage = 1, .shadowed = {3, 3, 3}, .unshadowed = {2, 2, 2}}), 0);
}

TEST(CaughtShadow, is_that_of_the_means_over_all_passes) {
  // Of the means of the ratios it would be (1/4·0 + 3/4·1).
  EXPECT_EQ(alpha_of({{1, {.coverage = 1, .shadowed = {4, 4, 4}, .unshadowed = {4, 4, 4}}},
                      {3, {.coverage = 1, .shadowed = {}, .unshadowed = {4, 4, 4}}}}),
            0.75F);
  EXPECT_EQ(alpha_of({{1, {.coverage = 1, .shadowed = {6, 6, 6}, .unshadowed = {6, 6, 6}}},
                      {3, {.coverage = 1, .shadowed = {}, .unshadowed = {2, 2, 2}}}}),
            0.5F);
}

/// A film of tiles of this side, of two passes of noise.
FilmSnapshot noisy_film(int tile_side) {
  const TileGrid grid(window.width, window.height, tile_side, window);
  Film film(grid, 0, layout());
  std::mt19937 random(3);
  for (const std::uint32_t n : {1U, 3U}) {
    TileImage whole = pass_of(window, n, {});
    for (std::size_t c = 0; c < whole.channels(); ++c)
      for (float& value : whole.plane(c)) value = static_cast<float>(random() % 1000U) * 1e-3F;
    for (std::uint32_t i = 0; i < grid.count(); ++i) {
      const Rect rect = grid.tile(i);
      TileImage part = pass_of(rect, n, {});
      for (std::size_t c = 0; c < part.channels(); ++c)
        for (int y = 0; y < rect.height; ++y)
          for (int x = 0; x < rect.width; ++x)
            part.plane(c)[static_cast<std::size_t>(y * rect.width + x)] =
                whole.plane(c)[static_cast<std::size_t>((y + rect.y) * window.width + x + rect.x)];
      film.fold(i, part);
    }
  }
  return film.snapshot();
}

TEST(CaughtShadow, has_the_same_bits_however_the_film_is_cut_and_wherever_it_is_read) {
  const FilmSnapshot whole = noisy_film(8);
  const std::vector<float> values = resolve(whole).values;
  const std::vector<float> picture = resolve_rgba(whole);
  EXPECT_TRUE(std::equal(picture.begin(), picture.end(), values.begin()));
  EXPECT_EQ(resolve(*whole.tiles[0]), values);
  for (const int tile_side : {1, 3, 5}) EXPECT_EQ(resolve(noisy_film(tile_side)).values, values);
}

TEST(CaughtShadow, is_in_the_tiles_of_the_preview) {
  Film film(TileGrid(window.width, window.height, 8, window), 0, layout());
  film.fold(
      0, pass_of(window, 2,
                 {.alpha = 0.25, .coverage = 0.5, .shadowed = {1, 1, 1}, .unshadowed = {2, 2, 2}}));
  const std::vector<std::byte> bytes = encode_changed_tiles(film.snapshot(), 0);
  std::array<std::uint16_t, 4> last{};
  std::memcpy(last.data(), bytes.data() + bytes.size() - sizeof last, sizeof last);
  EXPECT_EQ(last, (std::array<std::uint16_t, 4>{0x3000, 0, 0, 0x3800}));  // 1/8, 0, 0, 1/2
}

TEST(CaughtShadow, is_looked_for_in_no_film_without_catchers) {
  EXPECT_FALSE(first_caught(*image::default_layout()).has_value());
  FilmTile film = empty_film_tile(window);
  EXPECT_EQ(resolve(film)[image::A * film.pixels()], 0);
}

}  // namespace
}  // namespace tessera::server
