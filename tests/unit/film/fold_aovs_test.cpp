// Channels that are no means, seconds or nearest: ids, totals and Cryptomattes.
#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <random>

#include "common/job/matte_pixel.hpp"
#include "server/film/film_tile.hpp"

namespace tessera::server {
namespace {

using image::Layout;
using image::TileImage;

constexpr Rect window{5, 7, 4, 3};
constexpr std::size_t pixels = 12;

/// A pass of `n` samples; all values 0.
TileImage pass_of(const Layout& layout, std::uint32_t n, bool aovs) {
  TileImage tile{.window = window,
                 .film_width = 64,
                 .film_height = 64,
                 .samples = {n, aovs ? n : 0},
                 .values = {},
                 .layout = layout};
  tile.values.resize(tile.channels() * pixels);
  return tile;
}

std::size_t index(const Layout& layout, const char* channel) {
  const int found = layout->index_of(channel);
  EXPECT_GE(found, 0) << channel;
  return static_cast<std::size_t>(std::max(found, 0));
}

TEST(FoldIds, keeps_those_of_the_first_pass) {
  const Layout layout = image::layout_of(std::vector<std::string>{"object_id"});
  const std::size_t id = index(layout, "object_id");
  FilmTile film = empty_film_tile(window, layout);
  for (const float value : {3.0F, 1.0F, 9.0F}) {
    TileImage pass = pass_of(layout, 4, true);
    std::ranges::fill(pass.plane(id), value);
    pass.plane(id)[5] = value - 3;
    fold(film, pass);
  }
  fold(film, pass_of(layout, 16, false));
  const std::vector<float> values = resolve(film);
  EXPECT_EQ(values[id * pixels], 3.0F);
  EXPECT_EQ(values[id * pixels + 5], 0.0F);  // the first sample met nothing
}

TEST(FoldTime, sums_over_all_passes_and_divides_by_nothing) {
  const Layout layout = image::layout_of(std::vector<std::string>{"time"});
  const std::size_t time = index(layout, "time");
  FilmTile film = empty_film_tile(window, layout);
  for (const float seconds : {0.5F, 0.25F, 2.0F}) {
    TileImage pass = pass_of(layout, 64, false);
    std::ranges::fill(pass.plane(time), seconds);
    fold(film, pass);
  }
  EXPECT_EQ(resolve(film)[time * pixels + 7], 2.75F);
}

/// Passes of samples that each saw one of `kinds` ids or nothing, and the map that they pool to.
struct Seen {
  std::vector<TileImage> passes;
  std::vector<std::map<double, double>> pool = std::vector<std::map<double, double>>(pixels);

  Seen(const Layout& layout, std::size_t first, int kinds, const std::vector<int>& counts) {
    std::mt19937 random(11);
    for (const int count : counts) {
      TileImage pass = pass_of(layout, static_cast<std::uint32_t>(count), true);
      for (std::size_t p = 0; p < pixels; ++p) {
        MattePixel pixel;
        for (int i = 0; i < count; ++i) {
          // Low ids are seen more often than high ones.
          const auto drawn = static_cast<int>(random() % static_cast<unsigned>(kinds + 1));
          const double id = std::min(drawn, static_cast<int>(random() % 64U)) * 0.5;
          pixel.add(id, 1);
          if (id != 0) ++pool[p][id];
        }
        std::array<double, matte_channels> channels{};
        pixel.write(channels);
        for (std::size_t c = 0; c < matte_channels; ++c)
          pass.plane(first + c)[p] = static_cast<float>(channels[c]);
      }
      passes.push_back(std::move(pass));
    }
  }
};

std::map<double, double> entries_of(const FilmTile& film, std::size_t first, std::size_t pixel) {
  std::map<double, double> out;
  double before = 1e30;
  for (std::size_t slot = 0; slot < matte_slots; ++slot) {
    const double id = film.sums[(first + 2 * slot) * pixels + pixel];
    const double weight = film.sums[(first + 2 * slot + 1) * pixels + pixel];
    EXPECT_LE(weight, before) << "ranked";
    before = weight;
    if (id != 0) out[id] = weight;
  }
  return out;
}

const Layout& matte_layout() {
  static const Layout layout = image::layout_of(std::vector<std::string>{"CryptoObject"});
  return layout;
}

TEST(FoldMattes, is_the_exact_map_of_all_samples_where_it_has_slots) {
  const std::size_t first = index(matte_layout(), "CryptoObject00.R");
  const Seen seen(matte_layout(), first, 16, {1, 3, 12, 48});
  FilmTile film = empty_film_tile(window, matte_layout());
  for (const TileImage& pass : seen.passes) fold(film, pass);
  for (std::size_t p = 0; p < pixels; ++p) {
    EXPECT_EQ(entries_of(film, first, p), seen.pool[p]) << p;
    EXPECT_EQ(film.sums[(first + matte_channels - 1) * pixels + p], 0) << p;
  }
}

TEST(FoldMattes, counts_every_sample_that_has_no_slot) {
  const std::size_t first = index(matte_layout(), "CryptoObject00.R");
  const Seen seen(matte_layout(), first, 60, {1, 3, 12, 48, 192});
  FilmTile film = empty_film_tile(window, matte_layout());
  for (const TileImage& pass : seen.passes) fold(film, pass);
  for (std::size_t p = 0; p < pixels; ++p) {
    double all = 0, kept = 0;
    for (const auto& [id, weight] : seen.pool[p]) all += weight;
    for (const auto& [id, weight] : entries_of(film, first, p)) {
      kept += weight;
      EXPECT_LE(weight, seen.pool[p].at(id));
    }
    const double evicted = film.sums[(first + matte_channels - 1) * pixels + p];
    EXPECT_GT(evicted, 0);
    EXPECT_EQ(kept + evicted, all) << p;
  }
}

TEST(FoldMattes, gives_shares_of_the_samples_and_leaves_them_where_a_pass_has_none) {
  const std::size_t first = index(matte_layout(), "CryptoObject00.R");
  FilmTile film = empty_film_tile(window, matte_layout());
  TileImage pass = pass_of(matte_layout(), 4, true);
  std::ranges::fill(pass.plane(first), 2.5F);
  std::ranges::fill(pass.plane(first + 1), 3.0F);
  fold(film, pass);
  fold(film, pass_of(matte_layout(), 100, false));
  const std::vector<float> values = resolve(film);
  EXPECT_EQ(values[first * pixels], 2.5F);
  EXPECT_EQ(values[(first + 1) * pixels], 0.75F);
}

}  // namespace
}  // namespace tessera::server
