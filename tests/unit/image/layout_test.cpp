#include <gmock/gmock.h>

#include <cstring>

#include "common/base/error.hpp"
#include "common/image/picture.hpp"
#include "common/image/tile_view.hpp"
#include "tests/unit/image/make_tile.hpp"

namespace tessera::image {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Names = std::vector<std::string>;

TileImage tile_with(const Names& aovs) {
  TileImage tile{.window = {3, 5, 4, 3},
                 .film_width = 16,
                 .film_height = 12,
                 .samples = {4, 4},
                 .values = {},
                 .layout = layout_of(aovs)};
  tile.values.resize(tile.channels() * tile.pixels());
  for (std::size_t i = 0; i < tile.values.size(); ++i) tile.values[i] = static_cast<float>(i);
  return tile;
}

TEST(Layout, has_the_channels_of_the_AOVs_that_a_job_asks_for) {
  const Layout layout = layout_of(Names{"P", "Z"});
  EXPECT_EQ(layout->size(), 11U);
  EXPECT_EQ(layout->travelling(false), 7U);
  EXPECT_EQ(layout->index_of("Z"), 7);
  EXPECT_EQ(layout->index_of("P.Z"), 10);
  EXPECT_EQ(layout->index_of("albedo.R"), -1);
  EXPECT_EQ(*layout, *layout_of(Names{"Z", "P"}));
  EXPECT_NE(*layout, *default_layout());
  EXPECT_EQ(*default_layout(), *layout_of(Names{"N", "Z", "albedo"}));
}

TEST(Layout, has_what_makes_up_the_picture_among_what_travels_with_every_pass) {
  const Layout layout = layout_of(Names{"albedo", "light_key", "direct"});
  EXPECT_EQ(layout->index_of("direct.R"), 7);
  EXPECT_EQ(layout->index_of("light_key.B"), 12);
  EXPECT_EQ(layout->travelling(false), 13U);
  EXPECT_EQ(layout->index_of("albedo.R"), 13);
}

TEST(Layout, of_a_tile_goes_through_its_file) {
  const TileImage tile = tile_with({"P", "Z"});
  TileExpectation expected = expectation_of(tile);
  EXPECT_THROW(decode_tile(encode_tile(tile), expected), Error);
  expected.layout = tile.layout;
  const TileImage back = decode_tile(encode_tile(tile), expected);
  EXPECT_EQ(back.values, tile.values);
  const auto view = view_of(tile);
  EXPECT_EQ(view.row(10, 2)[3], tile.plane(10)[11]);
}

TEST(Layout, of_a_frame_names_the_channels_of_its_picture) {
  FrameImage frame{
      .width = 2, .height = 1, .values = {}, .samples = {1, 1}, .layout = layout_of(Names{"P"})};
  frame.values.assign(frame.layout->size() * frame.pixels(), 0.5F);
  const ExrImage back = read_exr(encode_exr(frame, {}));
  EXPECT_THAT(back.channels, ElementsAre("A", "B", "G", "P.X", "P.Y", "P.Z", "R", "samples",
                                         "variance.B", "variance.G", "variance.R"));
  EXPECT_THAT(back.plane("P.Y"), ElementsAre(0.5F, 0.5F));
}

TEST(Layout, of_a_cryptomatte_shows_six_ranks_of_what_a_film_keeps) {
  FrameImage frame{.width = 1,
                   .height = 1,
                   .values = {},
                   .samples = {1},
                   .layout = layout_of(Names{"CryptoObject"})};
  frame.values.resize(frame.layout->size());
  for (std::size_t i = 0; i < frame.values.size(); ++i) frame.values[i] = static_cast<float>(i);
  ASSERT_EQ(frame.layout->size(), 7U + 33U);
  JobSpec job;
  job.render.aovs = {"CryptoObject"};
  job.cryptomatte.objects = {"bunny", "default"};
  const ExrImage back = read_exr(encode_exr(frame, metadata_of(job, 1)));
  EXPECT_EQ(back.channels.size(), 4U + 3U + 1U + 12U + 1U);
  EXPECT_THAT(back.plane("CryptoObject00.R"), ElementsAre(7.0F));
  EXPECT_THAT(back.plane("CryptoObject02.A"), ElementsAre(18.0F));
  EXPECT_FALSE(back.has("CryptoObject03.R"));
  EXPECT_THAT(back.plane("evicted.CryptoObject"), ElementsAre(39.0F));
  EXPECT_EQ(back.metadata.text("cryptomatte/3ae39a5/name"), "CryptoObject");
  EXPECT_EQ(back.metadata.text("cryptomatte/3ae39a5/manifest"),
            R"({"bunny":"13851a76","default":"42c9679f"})");
}

TEST(Layout, refuses_a_matte_that_weighs_less_than_nothing) {
  TileImage tile = tile_with({"CryptoMaterial"});
  TileExpectation expected = expectation_of(tile);
  expected.layout = tile.layout;
  tile.plane(7)[2] = -3;  // an id may be negative
  EXPECT_NO_THROW(decode_tile(encode_tile(tile), expected));
  tile.plane(8)[2] = -3;
  EXPECT_THROW(decode_tile(encode_tile(tile), expected), Error);
}

}  // namespace
}  // namespace tessera::image
