#include "tests/peer/likeness.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "common/base/error.hpp"

namespace tessera::peer {
namespace {

constexpr int width = 64, height = 48;

/// A soft pattern seen through a camera that is turned and has a lens of another length.
image::ExrImage pattern(double right = 0, double down = 0, double larger = 0, double brighter = 1) {
  image::ExrImage out{
      .width = width, .height = height, .channels = {"B", "G", "R"}, .values = {}, .metadata = {}};
  for (const double color : {0.2, 0.5, 1.0})
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const double u = (x + 0.5 - width / 2.0 - right) / (1 + larger);
        const double v = (y + 0.5 - height / 2.0 - down) / (1 + larger);
        out.values.push_back(static_cast<float>(
            color * brighter * (1.5 + std::sin(0.3 * u + 0.1 * v) * std::cos(0.25 * v))));
      }
  return out;
}

TEST(Likeness, of_a_picture_with_itself_is_whole) {
  const Likeness like = compare(pattern(), pattern());
  EXPECT_EQ(like.first, like.second);
  EXPECT_EQ(like.rel_mse, 0);
  EXPECT_EQ(like.blocks.most, 0);
  EXPECT_EQ(like.framing.right, 0);
}

TEST(Likeness, tells_how_far_a_picture_was_moved_and_stretched) {
  const Framing framing = compare(pattern(0.4, -0.3, 0.004), pattern()).framing;
  EXPECT_NEAR(framing.right, 0.4, 0.02);
  EXPECT_NEAR(framing.down, -0.3, 0.02);
  EXPECT_NEAR(framing.larger, 0.004, 0.0005);
}

TEST(Likeness, of_a_brighter_picture_shows_in_means_and_blocks_alike) {
  const Likeness like = compare(pattern(0, 0, 0, 1.1), pattern());
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(like.first[c] / like.second[c], 1.1, 1e-6);
  EXPECT_NEAR(like.blocks.median, 0.1, 0.002);
  EXPECT_NEAR(like.blocks.most, 0.1, 0.002);
  EXPECT_NEAR(like.rel_mse, 0.01, 0.001);
}

TEST(Likeness, names_the_block_in_which_something_is_that_the_other_lacks) {
  image::ExrImage other = pattern();
  for (const std::size_t plane : {0U, 1U, 2U})
    for (int y = 16; y < 24; ++y)
      for (int x = 40; x < 48; ++x)
        other.values[(plane * height + static_cast<std::size_t>(y)) * width +
                     static_cast<std::size_t>(x)] *= 3;
  const Blocks blocks = compare(other, pattern()).blocks;
  EXPECT_NEAR(blocks.most, 2, 0.1);
  EXPECT_EQ(blocks.x, 40);
  EXPECT_EQ(blocks.y, 16);
  EXPECT_EQ(blocks.median, 0);
}

TEST(Likeness, of_pictures_of_two_sizes_is_an_error) {
  image::ExrImage smaller = pattern();
  smaller.height /= 2;
  EXPECT_THROW(compare(smaller, pattern()), Error);
}

}  // namespace
}  // namespace tessera::peer
