#include "server/film/film.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>

#include "common/base/error.hpp"

namespace tessera::server {
namespace {

using image::channel_count;
using image::TileImage;
using testing::ElementsAre;

constexpr int film_width = 50, film_height = 23;
const TileGrid grid(film_width, film_height, 16);

/// A pass over one tile, each pixel's values told by where it stands in the film, not in the tile.
TileImage pass_over(const TileGrid& cut, std::uint32_t tile, std::uint32_t n, float scale,
                    bool aovs = true) {
  TileImage pass{.window = cut.tile(tile),
                 .film_width = cut.film_width(),
                 .film_height = cut.film_height(),
                 .samples = {n, aovs ? n : 0},
                 .values = {}};
  for (std::size_t c = 0; c < pass.channels(); ++c)
    for (int y = 0; y < pass.window.height; ++y)
      for (int x = 0; x < pass.window.width; ++x)
        pass.values.push_back(
            scale * static_cast<float>(100 * (pass.window.y + y) + pass.window.x + x + 1) +
            static_cast<float>(c));
  return pass;
}

TEST(Film, begins_black_transparent_and_at_its_first_version) {
  Film film(grid);
  EXPECT_EQ(film.version(), 0U);
  EXPECT_EQ(film.passes(3), 0U);
  EXPECT_EQ(film.tile(3), nullptr);
  const image::FrameImage frame = resolve(film.snapshot());
  EXPECT_EQ(frame.pixels(), static_cast<std::size_t>(film_width * film_height));
  for (std::size_t c = 0; c < channel_count; ++c)
    EXPECT_THAT(frame.plane(c), testing::Each(c == image::Z ? 1e10F : 0.0F));
  EXPECT_THAT(frame.samples, testing::Each(0U));
}

TEST(Film, of_a_window_has_the_whole_films_values_there) {
  const Rect window{9, 5, 30, 13};
  const TileGrid cut(film_width, film_height, 16, window);
  Film whole(grid), part(cut);
  for (std::uint32_t tile = 0; tile < grid.count(); ++tile)
    whole.fold(tile, pass_over(grid, tile, 3, 0.7F));
  for (std::uint32_t tile = 0; tile < cut.count(); ++tile)
    part.fold(tile, pass_over(cut, tile, 3, 0.7F));
  const image::FrameImage all = resolve(whole.snapshot()), some = resolve(part.snapshot());
  ASSERT_EQ(some.width, window.width);
  ASSERT_EQ(some.height, window.height);
  for (std::size_t c = 0; c < channel_count; ++c)
    for (int y = 0; y < window.height; ++y)
      for (int x = 0; x < window.width; ++x)
        ASSERT_EQ(some.plane(c)[static_cast<std::size_t>(y * some.width + x)],
                  all.plane(c)[static_cast<std::size_t>((window.y + y) * all.width + window.x + x)])
            << c << ' ' << x << ' ' << y;
}

TEST(Film, counts_a_version_with_every_fold_and_tells_the_tiles_that_changed) {
  Film film(grid);
  film.fold(2, pass_over(grid, 2, 1, 1));
  film.fold(0, pass_over(grid, 0, 1, 1));
  film.fold(2, pass_over(grid, 2, 3, 1));
  EXPECT_EQ(film.version(), 3U);
  EXPECT_EQ(film.passes(2), 2U);
  const FilmSnapshot now = film.snapshot();
  EXPECT_THAT(changed_since(now, 0), ElementsAre(0, 2));
  EXPECT_THAT(changed_since(now, 1), ElementsAre(0, 2));
  EXPECT_THAT(changed_since(now, 2), ElementsAre(2));
  EXPECT_THAT(changed_since(now, 3), ElementsAre());
  EXPECT_THAT(changed_since(now, 4), ElementsAre(0, 2)) << "a version of another film";
}

TEST(Film, snapshot_stays_as_it_was_while_the_film_goes_on) {
  Film film(grid);
  film.fold(1, pass_over(grid, 1, 1, 1));
  const FilmSnapshot before = film.snapshot();
  const std::vector<double> sums = before.tiles[1]->sums;
  film.fold(1, pass_over(grid, 1, 3, 2));
  film.fold(0, pass_over(grid, 0, 1, 1));
  EXPECT_EQ(before.version, 1U);
  EXPECT_EQ(before.tiles[0], nullptr);
  EXPECT_EQ(before.tiles[1]->passes, 1U);
  EXPECT_EQ(before.tiles[1]->sums, sums);
  EXPECT_EQ(film.snapshot().tiles[1]->passes, 2U);
}

TEST(Film, a_tile_that_was_given_out_stays_as_it_was) {
  Film film(grid);
  film.fold(1, pass_over(grid, 1, 1, 1));
  const auto given = film.tile(1);
  film.fold(1, pass_over(grid, 1, 3, 2));
  EXPECT_EQ(given->passes, 1U);
  EXPECT_EQ(film.tile(1)->passes, 2U);
}

TEST(Film, copies_a_tile_only_after_it_was_given_out_and_shares_those_that_did_not_change) {
  Film film(grid);
  film.fold(0, pass_over(grid, 0, 1, 1));
  film.fold(1, pass_over(grid, 1, 1, 1));
  const FilmSnapshot first = film.snapshot();
  film.fold(1, pass_over(grid, 1, 3, 1));
  const FilmSnapshot second = film.snapshot();
  EXPECT_EQ(first.tiles[0], second.tiles[0]);
  EXPECT_NE(first.tiles[1], second.tiles[1]);
}

TEST(Film, folding_elsewhere_and_putting_in_gives_the_same_bits_as_folding_in_place) {
  Film in_place(grid), elsewhere(grid);
  for (const std::uint32_t n : {1U, 3U, 12U}) {
    const TileImage pass = pass_over(grid, 3, n, 1.0F / static_cast<float>(n));
    in_place.fold(3, pass);
    elsewhere.put(3, folded(elsewhere.tile(3).get(), pass));
  }
  EXPECT_EQ(in_place.tile(3)->sums, elsewhere.tile(3)->sums);
  EXPECT_EQ(in_place.tile(3)->samples, elsewhere.tile(3)->samples);
  EXPECT_EQ(elsewhere.version(), 3U);
}

TEST(Film, lends_a_tile_that_nobody_else_was_given_and_takes_it_back_with_the_same_bits) {
  Film in_place(grid), lending(grid);
  for (const std::uint32_t n : {1U, 3U, 12U}) {
    const TileImage pass = pass_over(grid, 3, n, 1.0F / static_cast<float>(n));
    in_place.fold(3, pass);
    auto sums = lending.lend(3);
    EXPECT_EQ(sums == nullptr, n == 1);
    if (!sums) sums = std::make_shared<FilmTile>(empty_film_tile(grid.tile(3)));
    fold(*sums, pass);
    lending.give_back(3, sums);
  }
  const FilmSnapshot given = lending.snapshot();
  EXPECT_EQ(given.tiles[3]->sums, in_place.tile(3)->sums);
  EXPECT_EQ(given.version, 3U);
  EXPECT_EQ(lending.lend(3), nullptr) << "the snapshot holds it";
  EXPECT_EQ(lending.tile(3), given.tiles[3]);
}

TEST(Film, restored_tiles_count_as_changed_at_the_version_where_counting_goes_on) {
  Film film(grid);
  film.fold(0, pass_over(grid, 0, 1, 1));
  film.fold(1, pass_over(grid, 1, 1, 1));
  Film again(grid, film.version());
  again.restore(0, film.tile(0));
  again.restore(1, film.tile(1));
  EXPECT_EQ(again.version(), 2U);
  EXPECT_THAT(changed_since(again.snapshot(), 1), ElementsAre(0, 1));
  EXPECT_THAT(changed_since(again.snapshot(), 2), ElementsAre());
  again.fold(1, pass_over(grid, 1, 3, 1));
  film.fold(1, pass_over(grid, 1, 3, 1));
  EXPECT_EQ(again.tile(1)->sums, film.tile(1)->sums);
  EXPECT_THAT(changed_since(again.snapshot(), 2), ElementsAre(1));
}

TEST(Film, refuses_tiles_of_another_film) {
  Film film(grid);
  const auto other = folded(nullptr, pass_over(grid, 1, 1, 1));
  EXPECT_THROW(film.put(0, other), Error);
  EXPECT_THROW(film.put(0, nullptr), Error);
  EXPECT_THROW(film.fold(0, pass_over(grid, 1, 1, 1)), Error);
  EXPECT_THROW(film.fold(99, pass_over(grid, 1, 1, 1)), std::out_of_range);
  EXPECT_EQ(film.version(), 0U);
  EXPECT_EQ(film.tile(0), nullptr);
}

TEST(Film, a_fold_that_fails_changes_neither_tile_nor_version) {
  Film film(grid);
  film.fold(0, pass_over(grid, 0, 1, 1));
  EXPECT_THROW(film.fold(0, pass_over(grid, 1, 1, 1)), Error);
  EXPECT_EQ(film.version(), 1U);
  EXPECT_EQ(film.passes(0), 1U);
}

TEST(Resolve, normalises_each_tile_by_its_own_samples) {
  Film film(grid);
  film.fold(0, pass_over(grid, 0, 4, 1));
  film.fold(1, pass_over(grid, 1, 4, 1));
  film.fold(1, pass_over(grid, 1, 12, 5));
  const image::FrameImage frame = resolve(film.snapshot());
  EXPECT_EQ(frame.plane(image::R)[2 * film_width + 3], 204.0F);
  EXPECT_EQ(frame.samples[2 * film_width + 3], 4U);
  EXPECT_EQ(frame.plane(image::R)[2 * film_width + 20], (4 * 221.0F + 12 * 5 * 221.0F) / 16);
  EXPECT_EQ(frame.samples[2 * film_width + 20], 16U);
  EXPECT_EQ(frame.samples[2 * film_width + 40], 0U);
  EXPECT_EQ(frame.plane(image::A)[2 * film_width + 40], 0.0F);
}

TEST(Resolve, gives_the_same_picture_for_any_tile_size) {
  std::vector<image::FrameImage> pictures;
  for (const int side : {1, 7, 16, 64}) {
    const TileGrid cut(film_width, film_height, side);
    Film film(cut);
    for (std::uint32_t pass = 0; pass < 3; ++pass)
      for (std::uint32_t tile = 0; tile < cut.count(); ++tile)
        film.fold(tile, pass_over(cut, tile, 1 + 2 * pass, 1.0F / static_cast<float>(pass + 3),
                                  pass < 2));
    pictures.push_back(resolve(film.snapshot()));
  }
  for (const auto& picture : pictures) {
    EXPECT_EQ(0, std::memcmp(picture.values.data(), pictures[0].values.data(),
                             picture.values.size() * sizeof(float)));
    EXPECT_EQ(picture.samples, pictures[0].samples);
  }
}

TEST(Resolve, of_RGBA_alone_has_the_same_values) {
  Film film(grid);
  for (const std::uint32_t tile : {0U, 3U, 7U}) film.fold(tile, pass_over(grid, tile, 3, 0.1F));
  const image::FrameImage frame = resolve(film.snapshot());
  const std::vector<float> rgba = resolve_rgba(film.snapshot());
  ASSERT_EQ(rgba.size(), 4 * frame.pixels());
  EXPECT_TRUE(std::equal(rgba.begin(), rgba.end(), frame.values.begin()));
}

/// IEEE 754 half to float, as the standard says.
float float_of_half(std::uint16_t bits) {
  const int exponent = (bits >> 10) & 31;
  const float mantissa = static_cast<float>(bits & 1023);
  const float value =
      exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
  return (bits & 0x8000) != 0 ? -value : value;
}

struct DecodedTiles {
  nlohmann::json header;
  std::vector<float> values;
};

DecodedTiles decode_tiles(const std::vector<std::byte>& bytes) {
  EXPECT_EQ(0, std::memcmp(bytes.data(), "TSRT", 4));
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 4, sizeof length);
  EXPECT_EQ(length % 8, 0U);
  DecodedTiles out;
  const char* text = reinterpret_cast<const char*>(bytes.data()) + 8;
  out.header = nlohmann::json::parse(text, text + length);
  for (std::size_t at = 8 + length; at < bytes.size(); at += 2) {
    std::uint16_t half = 0;
    std::memcpy(&half, bytes.data() + at, sizeof half);
    out.values.push_back(float_of_half(half));
  }
  return out;
}

TEST(ChangedTiles, are_encoded_as_README_says) {
  Film film(grid);
  film.fold(0, pass_over(grid, 0, 1, 0.25F));
  film.fold(7, pass_over(grid, 7, 1, 0.25F));
  const DecodedTiles tiles = decode_tiles(encode_changed_tiles(film.snapshot(), 1));
  EXPECT_EQ(tiles.header, nlohmann::json::parse(R"({"version": 2, "width": 50, "height": 23,
    "tiles": [{"x": 48, "y": 16, "width": 2, "height": 7}]})"));
  ASSERT_EQ(tiles.values.size(), 2U * 7 * 4);
  // Pixel (49, 17): 0.25·(1700 + 49 + 1) + channel, in steps of 1/4 and then 1/2 that a half can
  // hold.
  const std::size_t at = (1 * 2 + 1) * 4;
  EXPECT_EQ(tiles.values[at + 0], 437.5F);
  EXPECT_EQ(tiles.values[at + 1], 438.5F);
  EXPECT_EQ(tiles.values[at + 3], 440.5F);
}

TEST(ChangedTiles, of_a_film_that_did_not_change_are_a_header_alone) {
  Film film(grid);
  const DecodedTiles tiles = decode_tiles(encode_changed_tiles(film.snapshot(), 0));
  EXPECT_EQ(tiles.header["tiles"].size(), 0U);
  EXPECT_EQ(tiles.values.size(), 0U);
}

TEST(ChangedTiles, keep_what_a_half_cannot_hold_within_its_range) {
  const TileGrid one(1, 1, 1);
  Film film(one);
  TileImage pass = pass_over(one, 0, 1, 1);
  pass.values[image::R] = 1e9F;
  pass.values[image::G] = -1e9F;
  pass.values[image::B] = 1e-30F;
  pass.values[image::A] = 1;
  film.fold(0, pass);
  EXPECT_THAT(decode_tiles(encode_changed_tiles(film.snapshot(), 0)).values,
              ElementsAre(65504, -65504, 0, 1));
}

}  // namespace
}  // namespace tessera::server
