#include "server/film/noise.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tessera::server {
namespace {

constexpr int side = 20;
const TileGrid grid(side, side, 16);

/// A pass of `n` samples in which pixel (x, y) has the light `light(x, y)`, gray, and samples that
/// are off it by `spread(x, y)` in the root mean square.
template <class Light, class Spread>
Film film_of(std::uint32_t n, Light light, Spread spread) {
  Film film(grid);
  for (std::uint32_t tile = 0; tile < grid.count(); ++tile) {
    image::TileImage pass{.window = grid.tile(tile),
                          .film_width = side,
                          .film_height = side,
                          .samples = {n, 0},
                          .values = {}};
    pass.values.assign(pass.channels() * pass.pixels(), 0);
    for (std::size_t i = 0; i < pass.pixels(); ++i) {
      const int x = pass.window.x + static_cast<int>(i) % pass.window.width;
      const int y = pass.window.y + static_cast<int>(i) / pass.window.width;
      const auto off = static_cast<float>(spread(x, y));
      for (std::size_t c = 0; c < 3; ++c) {
        pass.values[(image::R + c) * pass.pixels() + i] = static_cast<float>(light(x, y));
        pass.values[(image::M2_R + c) * pass.pixels() + i] = off * off * static_cast<float>(n);
      }
    }
    film.fold(tile, pass);
  }
  return film;
}
constexpr auto always = [](double value) { return [value](int, int) { return value; }; };

TEST(Noise, IsTheErrorOfTheMeanOverTheLight) {
  Film film = film_of(65, always(2), always(0.5));
  // σ/√(n−1) over 2 + a tenth of the mean light.
  EXPECT_NEAR(noise_of(film.snapshot()), 0.5 / 8 / 2.2, 1e-6);
}

TEST(Noise, FallsWithTheRootOfTheSamplesAndNotWithExposure) {
  const auto light = [](int x, int y) { return 0.1 + x + 3 * y; };
  const auto spread = [](int x, int y) { return 0.3 * x + y; };
  const double few = noise_of(film_of(17, light, spread).snapshot());
  EXPECT_NEAR(noise_of(film_of(65, light, spread).snapshot()) / few, 0.5, 1e-6);
  const auto brighter = [&](int x, int y) { return 1024 * light(x, y); };
  const auto wider = [&](int x, int y) { return 1024 * spread(x, y); };
  EXPECT_EQ(noise_of(film_of(17, brighter, wider).snapshot()), few);
}

TEST(Noise, LeavesTheNoisiestHundredthOut) {
  const auto spread = [](int x, int y) { return y == 0 && x < 4 ? 1e6 : 0.5; };
  EXPECT_EQ(noise_of(film_of(65, always(2), spread).snapshot()),
            noise_of(film_of(65, always(2), always(0.5)).snapshot()));
  const auto five = [](int x, int y) { return y == 0 && x < 5 ? 1e6 : 0.5; };
  EXPECT_GT(noise_of(film_of(65, always(2), five).snapshot()), 1);
}

TEST(Noise, OfABlackFilmIsNoneAndOfOneWithoutSamplesBeyondAll) {
  EXPECT_EQ(noise_of(film_of(16, always(0), always(0)).snapshot()), 0);
  EXPECT_TRUE(std::isinf(noise_of(film_of(1, always(1), always(0)).snapshot())));
  EXPECT_TRUE(std::isinf(noise_of(Film(grid).snapshot())));
}

}  // namespace
}  // namespace tessera::server
