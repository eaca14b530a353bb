#include "common/job/tile_grid.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "common/job/task.hpp"

namespace tessera {
namespace {

TEST(TileGrid, covers_every_pixel_exactly_once_whatever_the_sizes) {
  for (const int width : {1, 2, 15, 16, 17, 64, 131, 250})
    for (const int height : {1, 16, 23, 131})
      for (const int side : {1, 7, 16, 23, 64, 512}) {
        const TileGrid grid(width, height, side);
        std::vector<int> covered(static_cast<std::size_t>(width * height));
        for (std::uint32_t i = 0; i < grid.count(); ++i) {
          const Rect tile = grid.tile(i);
          ASSERT_GE(tile.x, 0);
          ASSERT_GE(tile.y, 0);
          ASSERT_LE(tile.x + tile.width, width);
          ASSERT_LE(tile.y + tile.height, height);
          ASSERT_LE(tile.width, side);
          ASSERT_LE(tile.height, side);
          for (int y = tile.y; y < tile.y + tile.height; ++y)
            for (int x = tile.x; x < tile.x + tile.width; ++x)
              ++covered[static_cast<std::size_t>(y * width + x)];
        }
        ASSERT_EQ(covered, std::vector<int>(covered.size(), 1))
            << width << "x" << height << " by " << side;
      }
}

TEST(TileGrid, of_a_window_has_what_the_films_tiles_have_within_it) {
  const TileGrid film(131, 70, 16);
  for (const Rect& window : {Rect{0, 0, 131, 70}, Rect{16, 32, 16, 16}, Rect{5, 6, 7, 8},
                             Rect{15, 17, 2, 40}, Rect{130, 69, 1, 1}, Rect{31, 0, 100, 70}}) {
    const TileGrid grid(131, 70, 16, window);
    std::int64_t pixels = 0;
    for (std::uint32_t index = 0; index < grid.count(); ++index) {
      const Rect tile = grid.tile(index);
      pixels += tile.pixels();
      EXPECT_TRUE(tile.x >= window.x && tile.x + tile.width <= window.x + window.width);
      EXPECT_TRUE(tile.y >= window.y && tile.y + tile.height <= window.y + window.height);
      const auto column = static_cast<int>(index) % grid.columns();
      const auto row = static_cast<int>(index) / grid.columns();
      EXPECT_EQ(grid.column_of(tile.x), column);
      EXPECT_EQ(grid.row_of(tile.y + tile.height - 1), row);
      EXPECT_EQ(film.column_of(tile.x), film.column_of(tile.x + tile.width - 1));
      EXPECT_EQ(film.row_of(tile.y), film.row_of(tile.y + tile.height - 1));
    }
    EXPECT_EQ(pixels, window.pixels()) << window.x;
  }
}

TEST(TileGrid, numbers_tiles_in_rows_from_the_upper_left_and_cuts_the_last_ones) {
  const TileGrid grid(250, 131, 64);
  EXPECT_EQ(grid.columns(), 4);
  EXPECT_EQ(grid.rows(), 3);
  EXPECT_EQ(grid.count(), 12U);
  EXPECT_EQ(grid.tile(0), (Rect{0, 0, 64, 64}));
  EXPECT_EQ(grid.tile(3), (Rect{192, 0, 58, 64}));
  EXPECT_EQ(grid.tile(4), (Rect{0, 64, 64, 64}));
  EXPECT_EQ(grid.tile(11), (Rect{192, 128, 58, 3}));
}

TEST(TileGrid, of_the_largest_film_does_not_overflow) {
  const TileGrid grid(65536, 8192, 1);
  EXPECT_EQ(grid.count(), 65536U * 8192U);
  EXPECT_EQ(grid.tile(grid.count() - 1), (Rect{65535, 8191, 1, 1}));
  EXPECT_EQ((Rect{0, 0, 65536, 65536}.pixels()), 1LL << 32);
}

TEST(JobId, is_read_from_decimal_digits_alone) {
  EXPECT_EQ(job_id_from("17"), 17U);
  EXPECT_EQ(job_id_from("18446744073709551615"), UINT64_MAX);
  for (const char* text :
       {"", "0", "-1", "+1", " 1", "1 ", "1x", "0x1", "18446744073709551616", "1.0"})
    EXPECT_FALSE(job_id_from(text)) << text;
}

TEST(TaskId, says_frame_tile_and_pass) {
  EXPECT_EQ(text_of({.frame = -1, .tile = 17, .pass = 3}), "frame -1 tile 17 pass 3");
}

}  // namespace
}  // namespace tessera
