#include "server/film/film_tile.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "common/base/error.hpp"
#include "server/film/film.hpp"
#include "server/film/film_tile_bytes.hpp"

namespace tessera::server {
namespace {

using image::channel_count;
using image::TileImage;

/// Samples of one pixel of a tile, all channels that a sample has: R G B A, albedo, N, Z.
struct Sample {
  std::array<double, 3> rgb{};
  double alpha = 0;
  std::array<double, 3> albedo{};
  std::array<double, 3> normal{};
  double z = 0;
};

constexpr Rect window{5, 7, 4, 3};
constexpr std::size_t pixels = 12;

/// The samples of a pass: each pass about another mean, so that a fold which forgets a weight is
/// found out.
std::vector<std::vector<Sample>> draw_pass(int n, double about, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0, 1);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<std::vector<Sample>> drawn(pixels, std::vector<Sample>(static_cast<std::size_t>(n)));
  for (auto& pixel : drawn)
    for (Sample& sample : pixel) {
      for (double& value : sample.rgb) value = about + 0.3 * about * normal(random);
      sample.alpha = uniform(random) < 0.5 ? 0 : 1;
      for (double& value : sample.albedo) value = uniform(random);
      for (double& value : sample.normal) value = 2 * uniform(random) - 1;
      sample.z = uniform(random) < 0.3 ? 1e10 : about + uniform(random);
    }
  return drawn;
}

/// What a worker would send: means and second moments of the pass alone.
TileImage tile_of(const std::vector<std::vector<Sample>>& drawn, bool aovs) {
  const auto n = static_cast<std::uint32_t>(drawn[0].size());
  TileImage tile{.window = window,
                 .film_width = 64,
                 .film_height = 64,
                 .samples = {n, aovs ? n : 0},
                 .values = {}};
  tile.values.resize(tile.channels() * pixels);
  for (std::size_t p = 0; p < pixels; ++p) {
    const auto mean = [&](auto value) {
      double sum = 0;
      for (const Sample& sample : drawn[p]) sum += value(sample);
      return sum / n;
    };
    for (std::size_t c = 0; c < 3; ++c) {
      const double centre = mean([&](const Sample& s) { return s.rgb[c]; });
      tile.plane(image::R + c)[p] = static_cast<float>(centre);
      tile.plane(image::M2_R + c)[p] = static_cast<float>(
          n * mean([&](const Sample& s) { return (s.rgb[c] - centre) * (s.rgb[c] - centre); }));
      if (!aovs) continue;
      tile.plane(image::albedo_R + c)[p] =
          static_cast<float>(mean([&](const Sample& s) { return s.albedo[c]; }));
      tile.plane(image::N_X + c)[p] =
          static_cast<float>(mean([&](const Sample& s) { return s.normal[c]; }));
    }
    tile.plane(image::A)[p] = static_cast<float>(mean([](const Sample& s) { return s.alpha; }));
    if (!aovs) continue;
    double nearest = 1e10;
    for (const Sample& sample : drawn[p]) nearest = std::min(nearest, sample.z);
    tile.plane(image::Z)[p] = static_cast<float>(nearest);
  }
  return tile;
}

/// The oracle: all samples of all passes pooled, in long double, in two sweeps; it knows nothing of
/// folding.
struct Pool {
  std::vector<std::vector<Sample>> samples = std::vector<std::vector<Sample>>(pixels);
  void add(const std::vector<std::vector<Sample>>& drawn) {
    for (std::size_t p = 0; p < pixels; ++p)
      samples[p].insert(samples[p].end(), drawn[p].begin(), drawn[p].end());
  }
  template <class Value>
  [[nodiscard]] long double mean(std::size_t p, Value value) const {
    long double sum = 0;
    for (const Sample& sample : samples[p]) sum += static_cast<long double>(value(sample));
    return sum / static_cast<long double>(samples[p].size());
  }
  template <class Value>
  [[nodiscard]] long double moment2(std::size_t p, Value value) const {
    const long double centre = mean(p, value);
    long double sum = 0;
    for (const Sample& sample : samples[p]) {
      const long double off = static_cast<long double>(value(sample)) - centre;
      sum += off * off;
    }
    return sum;
  }
};

void expect_near(float found, long double expected, const char* what, std::size_t p) {
  // A pass's mean is rounded once to float, so a value may be off by about its last bit.
  const auto tolerance = static_cast<double>(std::max(1e-6L, 4e-6L * std::fabs(expected)));
  EXPECT_NEAR(static_cast<double>(found), static_cast<double>(expected), tolerance)
      << what << " of pixel " << p;
}

TEST(Fold, of_passes_of_1_3_and_12_samples_agrees_with_a_pool_of_all_samples_in_every_channel) {
  std::mt19937_64 random(42);
  FilmTile film = empty_film_tile(window);
  Pool beauty, aov;
  struct Pass {
    int n;
    double about;
    bool aovs;
  };
  for (const Pass& pass :
       {Pass{1, 0.25, true}, Pass{3, 4.0, true}, Pass{12, 1.5, true}, Pass{48, 2.5, false}}) {
    const auto drawn = draw_pass(pass.n, pass.about, random);
    beauty.add(drawn);
    if (pass.aovs) aov.add(drawn);
    fold(film, tile_of(drawn, pass.aovs));
    const std::vector<float> values = resolve(film);
    const auto value = [&](std::size_t channel, std::size_t p) {
      return values[channel * pixels + p];
    };
    for (std::size_t p = 0; p < pixels; ++p) {
      for (std::size_t c = 0; c < 3; ++c) {
        const auto colour = [&](const Sample& s) { return s.rgb[c]; };
        expect_near(value(image::R + c, p), beauty.mean(p, colour), "mean", p);
        expect_near(value(image::M2_R + c, p), beauty.moment2(p, colour), "M2", p);
        expect_near(value(image::albedo_R + c, p),
                    aov.mean(p, [&](const Sample& s) { return s.albedo[c]; }), "albedo", p);
        expect_near(value(image::N_X + c, p),
                    aov.mean(p, [&](const Sample& s) { return s.normal[c]; }), "N", p);
      }
      expect_near(value(image::A, p), beauty.mean(p, [](const Sample& s) { return s.alpha; }), "A",
                  p);
      double nearest = 1e10;
      for (const Sample& sample : aov.samples[p]) nearest = std::min(nearest, sample.z);
      EXPECT_EQ(value(image::Z, p), static_cast<float>(nearest)) << p;
    }
  }
  EXPECT_EQ(film.passes, 4U);
  EXPECT_EQ(film.samples, (std::array<std::uint64_t, 2>{64, 16}));
}

TileImage constant_tile(std::uint32_t n, float value, float m2, bool aovs) {
  TileImage tile{.window = window,
                 .film_width = 64,
                 .film_height = 64,
                 .samples = {n, aovs ? n : 0},
                 .values = {}};
  tile.values.assign(tile.channels() * pixels, value);
  for (const std::size_t c : {image::M2_R, image::M2_G, image::M2_B})
    std::ranges::fill(tile.plane(c), m2);
  return tile;
}

TEST(Fold, by_hand_weights_means_by_samples_and_adds_the_distance_of_means_to_second_moments) {
  FilmTile film = empty_film_tile(window);
  fold(film, constant_tile(1, 2.0F, 0.0F, true));
  fold(film, constant_tile(3, 6.0F, 1.5F, true));
  const std::vector<float> values = resolve(film);
  EXPECT_EQ(values[image::R * pixels], 5.0F);      // (1·2 + 3·6) / 4
  EXPECT_EQ(values[image::M2_R * pixels], 13.5F);  // 0 + 1.5 + (6 − 2)²·1·3/4
  EXPECT_EQ(values[image::albedo_G * pixels + 3], 5.0F);
  EXPECT_EQ(values[image::Z * pixels], 2.0F);
}

TEST(Fold, of_a_pass_without_AOVs_leaves_them_and_their_count_as_they_were) {
  FilmTile film = empty_film_tile(window);
  fold(film, constant_tile(4, 1.0F, 0.0F, true));
  const std::vector<float> before = resolve(film);
  fold(film, constant_tile(12, 9.0F, 0.0F, false));
  const std::vector<float> after = resolve(film);
  EXPECT_EQ(film.samples[0], 16U);
  EXPECT_EQ(film.samples[1], 4U);
  EXPECT_TRUE(std::equal(before.begin() + image::albedo_R * pixels, before.end(),
                         after.begin() + image::albedo_R * pixels));
  EXPECT_EQ(after[image::R * pixels], 7.0F);
}

TEST(Fold, keeps_what_a_float_sum_would_lose) {
  FilmTile film = empty_film_tile(window);
  fold(film, constant_tile(1U << 20, 16.0F, 0.0F, true));
  for (int i = 0; i < 1000; ++i) fold(film, constant_tile(1, 1.0F, 0.0F, false));
  const double exact = (16.0 * (1U << 20) + 1000.0) / ((1U << 20) + 1000.0);
  EXPECT_EQ(resolve(film)[image::R * pixels], static_cast<float>(exact));
}

/// The same passes in another order give other bits: this is why the film takes them in order only.
TEST(Fold, depends_on_the_order_so_that_the_order_has_to_be_fixed) {
  std::mt19937_64 random(7);
  std::vector<TileImage> passes;
  for (const int n : {1, 3, 12, 48, 192, 256})
    passes.push_back(tile_of(draw_pass(n, 1.0 / n + 0.1, random), true));
  const auto folded_in = [](const std::vector<TileImage>& order) {
    FilmTile film = empty_film_tile(window);
    for (const TileImage& pass : order) fold(film, pass);
    return film;
  };
  const FilmTile first = folded_in(passes);
  EXPECT_EQ(first.sums, folded_in(passes).sums);
  std::ranges::reverse(passes);
  EXPECT_NE(first.sums, folded_in(passes).sums);
}

/// A pixel's bits do not know how the film is cut.
TEST(Fold, gives_a_pixel_the_same_bits_in_a_tile_of_another_size) {
  std::mt19937_64 random(8);
  FilmTile whole = empty_film_tile(window), part = empty_film_tile({6, 8, 1, 1});
  const std::size_t inside = 1 * 4 + 1;
  for (const int n : {1, 3, 12}) {
    const TileImage tile = tile_of(draw_pass(n, 2.0 / n, random), true);
    TileImage cut{.window = part.window,
                  .film_width = 64,
                  .film_height = 64,
                  .samples = tile.samples,
                  .values = {}};
    for (std::size_t c = 0; c < channel_count; ++c) cut.values.push_back(tile.plane(c)[inside]);
    fold(whole, tile);
    fold(part, cut);
  }
  for (std::size_t c = 0; c < channel_count; ++c)
    EXPECT_EQ(std::bit_cast<std::uint64_t>(whole.sums[c * pixels + inside]),
              std::bit_cast<std::uint64_t>(part.sums[c]))
        << c;
}

TEST(Fold, refuses_a_pass_of_another_window_or_with_lacking_planes_and_leaves_the_film) {
  FilmTile film = empty_film_tile(window);
  TileImage elsewhere = constant_tile(1, 1.0F, 0.0F, true);
  elsewhere.window.x += 4;
  EXPECT_THROW(fold(film, elsewhere), Error);
  TileImage lacking = constant_tile(1, 1.0F, 0.0F, true);
  lacking.values.pop_back();
  EXPECT_THROW(fold(film, lacking), Error);
  TileImage nothing = constant_tile(0, 1.0F, 0.0F, false);
  EXPECT_THROW(fold(film, nothing), Error);
  EXPECT_EQ(film.passes, 0U);
  EXPECT_EQ(film.sums, empty_film_tile(window).sums);
}

TEST(Fold, takes_the_channels_of_a_jobs_layout_and_no_others) {
  const image::Layout layout = image::layout_of(std::vector<std::string>{"P", "direct"});
  const auto pass = [&](std::uint32_t n, float value, bool aovs) {
    TileImage tile = constant_tile(n, value, 0.0F, false);
    tile.layout = layout;
    tile.samples[1] = aovs ? n : 0;
    tile.values.resize(tile.channels() * pixels, value);
    return tile;
  };
  FilmTile film = empty_film_tile(window, layout);
  EXPECT_THROW(fold(film, constant_tile(1, 2.0F, 0.0F, true)), Error);
  fold(film, pass(1, 2.0F, true));
  fold(film, pass(3, 6.0F, false));
  const auto at = [&](const char* channel) {
    return resolve(film)[static_cast<std::size_t>(layout->index_of(channel)) * pixels];
  };
  EXPECT_EQ(at("direct.G"), 5.0F);
  EXPECT_EQ(at("P.Z"), 2.0F);
  const FilmTile back = film_tile_from(bytes_of(film), window, layout);
  EXPECT_EQ(back.sums, film.sums);
  EXPECT_EQ(*back.layout, *layout);
  EXPECT_THROW(film_tile_from(bytes_of(film), window, image::default_layout()), Error);
}

TEST(EmptyFilmTile, resolves_to_black_transparent_and_nothing_hit) {
  const std::vector<float> values = resolve(empty_film_tile(window));
  ASSERT_EQ(values.size(), channel_count * pixels);
  EXPECT_TRUE(std::all_of(values.begin(), values.begin() + image::Z * pixels,
                          [](float v) { return v == 0; }));
  EXPECT_TRUE(std::all_of(values.begin() + image::Z * pixels, values.end(),
                          [](float v) { return v == 1e10F; }));
}

}  // namespace
}  // namespace tessera::server
