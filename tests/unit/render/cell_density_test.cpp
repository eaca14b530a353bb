#include "worker/render/lights/cell_density.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/unit/render/chi2.hpp"

namespace tessera::render {
namespace {

struct Grid {
  std::size_t columns, rows;
  double kept;  ///< how many of its cells have a weight
};

/// Weights that reach over six decades, many of them 0.
std::vector<std::vector<double>> weights_of(const Grid& grid, test::Random& random) {
  std::vector<std::vector<double>> rows(grid.rows);
  for (std::vector<double>& row : rows)
    for (std::size_t x = 0; x < grid.columns; ++x)
      row.push_back(random.next() < grid.kept ? std::pow(10.0, 6.0 * random.next() - 3) : 0);
  return rows;
}

CellDensity density_of(const std::vector<std::vector<double>>& rows) {
  CellDensity out;
  for (const std::vector<double>& row : rows) out.add_row(row);
  out.finish();
  return out;
}

TEST(CellDensity, PointsLieInCellsThatHaveAWeightAndAreDrawnByIt) {
  test::Random random(4);
  for (const Grid& grid : {Grid{1, 1, 1}, Grid{7, 3, 1}, Grid{64, 32, 0.5}, Grid{1, 100, 0.1},
                           Grid{1000, 1, 0.02}, Grid{333, 77, 0.3}}) {
    std::vector<std::vector<double>> rows = weights_of(grid, random);
    rows.back().back() = 1;
    const CellDensity cells = density_of(rows);
    ASSERT_TRUE(cells.any());
    for (int i = 0; i < 20'000; ++i) {
      Vec2 u = random.next2();
      if (i % 5 == 0) u.x = static_cast<float>(i % 7) / 7;
      if (i % 11 == 0) u.y = 0;
      if (i % 13 == 0) u.x = one_minus_epsilon;
      const auto [point, density] = cells.sample(u);
      ASSERT_GT(density, 0) << u.x << ' ' << u.y;
      ASSERT_EQ(density, cells.density(point)) << u.x << ' ' << u.y;
      const auto x = static_cast<std::size_t>(point.x * static_cast<double>(grid.columns));
      const auto y = static_cast<std::size_t>(point.y * static_cast<double>(grid.rows));
      ASSERT_GT(rows[y][x], 0) << u.x << ' ' << u.y;
    }
  }
}

TEST(CellDensity, PointsRiseWithTheNumbersThatTheyAreMadeOf) {
  // So what is stratified stays it, whatever cell a search begins in.
  test::Random random(5);
  const CellDensity cells = density_of(weights_of({500, 1, 0.4}, random));
  double last = 0;
  for (int i = 0; i < 100'000; ++i) {
    const double x = cells.sample({static_cast<float>(i) / 100'000, 0.5F}).point.x;
    ASSERT_GE(x, last) << i;
    last = x;
  }
}

TEST(CellDensity, WithoutAWeightAllCellsAreAlike) {
  const CellDensity cells = density_of({{0, 0, 0, 0}, {0, 0, 0, 0}});
  EXPECT_FALSE(cells.any());
  EXPECT_NEAR(cells.sample({0.3F, 0.6F}).point.x, 0.3, 1e-6);
  EXPECT_NEAR(cells.sample({0.3F, 0.6F}).density, 1, 1e-6);
}

}  // namespace
}  // namespace tessera::render
