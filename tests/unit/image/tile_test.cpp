#include "common/image/tile.hpp"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfIntAttribute.h>
#include <gmock/gmock.h>

#include <cstring>
#include <filesystem>
#include <string>

#include "common/base/files.hpp"
#include "tests/unit/image/make_tile.hpp"

namespace tessera::image {
namespace {

using testing::ElementsAre;

TEST(Channels, stand_in_the_documented_order_with_the_beauty_group_first) {
  std::vector<std::string> names;
  for (const Channel& channel : default_layout()->channels()) names.push_back(channel.name);
  EXPECT_THAT(names, ElementsAre("R", "G", "B", "A", "M2.R", "M2.G", "M2.B", "albedo.R", "albedo.G",
                                 "albedo.B", "N.X", "N.Y", "N.Z", "Z"));
  EXPECT_EQ(default_layout()->travelling(false), 7U);
  EXPECT_EQ(default_layout()->travelling(true), 14U);
  EXPECT_EQ(default_layout()->index_of("N.X"), N_X);
  EXPECT_EQ(default_layout()->index_of("Z"), Z);
  EXPECT_EQ(default_layout()->index_of("z"), -1);
}

TEST(Channels, second_moments_name_the_channel_that_they_belong_to) {
  EXPECT_EQ((*default_layout())[M2_R].mean_of, static_cast<int>(R));
  EXPECT_EQ((*default_layout())[M2_G].mean_of, static_cast<int>(G));
  EXPECT_EQ((*default_layout())[M2_B].mean_of, static_cast<int>(B));
  EXPECT_EQ((*default_layout())[Z].merge, Merge::nearest);
}

class TileRoundTrip : public testing::TestWithParam<std::tuple<Rect, bool>> {};

TEST_P(TileRoundTrip, gives_every_bit_back) {
  const auto& [window, aovs] = GetParam();
  const TileImage tile = make_tile(window, 250, 131, 12, aovs);
  const TileImage back = decode_tile(encode_tile(tile), expectation_of(tile));
  EXPECT_EQ(back.window, tile.window);
  EXPECT_EQ(back.film_width, 250);
  EXPECT_EQ(back.film_height, 131);
  EXPECT_EQ(back.samples, tile.samples);
  ASSERT_EQ(back.values.size(), tile.values.size());
  EXPECT_EQ(
      0, std::memcmp(back.values.data(), tile.values.data(), tile.values.size() * sizeof(float)));
}

INSTANTIATE_TEST_SUITE_P(Windows, TileRoundTrip,
                         testing::Combine(testing::Values(Rect{0, 0, 64, 64}, Rect{192, 128, 58, 3},
                                                          Rect{249, 130, 1, 1},
                                                          Rect{0, 0, 250, 131},
                                                          Rect{23, 46, 23, 23}),
                                          testing::Bool()));

TEST(TileRoundTrip, keeps_signs_of_zero_denormals_and_the_largest_numbers) {
  TileImage tile = make_tile({0, 0, 2, 2}, 2, 2, 1, true);
  tile.values[0] = -0.0F;
  tile.values[1] = 1e-45F;
  tile.values[2] = 3.4028235e38F;
  tile.values[3] = -7.0F;
  tile.plane(Z)[0] = nothing_hit_z;
  const TileImage back = decode_tile(encode_tile(tile), expectation_of(tile));
  EXPECT_EQ(
      0, std::memcmp(back.values.data(), tile.values.data(), tile.values.size() * sizeof(float)));
}

TEST(EncodedTile, has_the_same_bytes_for_the_same_tile) {
  EXPECT_EQ(encode_tile(make_tile({0, 0, 16, 16}, 32, 32, 4, true)),
            encode_tile(make_tile({0, 0, 16, 16}, 32, 32, 4, true)));
  EXPECT_NE(encode_tile(make_tile({0, 0, 16, 16}, 32, 32, 4, true)),
            encode_tile(make_tile({0, 0, 16, 16}, 32, 32, 5, true)));
}

/// OpenEXR's own reader, from a file: what any other program would see.
TEST(EncodedTile, is_read_by_OpenEXRs_own_InputFile) {
  const TileImage tile = make_tile({192, 64, 58, 40}, 250, 131, 48, true);
  const auto path = std::filesystem::path(testing::TempDir()) / "tessera_tile_test.exr";
  write_file_atomically(path, encode_tile(tile));
  {
    Imf::InputFile file(path.c_str());
    const Imf::Header& header = file.header();
    EXPECT_EQ(header.dataWindow(), Imath::Box2i({192, 64}, {249, 103}));
    EXPECT_EQ(header.displayWindow(), Imath::Box2i({0, 0}, {249, 130}));
    EXPECT_EQ(header.compression(), Imf::NO_COMPRESSION);
    EXPECT_EQ(header.typedAttribute<Imf::IntAttribute>("tessera.samples.beauty").value(), 48);
    EXPECT_EQ(header.typedAttribute<Imf::IntAttribute>("tessera.samples.aov").value(), 48);
    std::size_t channels = 0;
    for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
      ++channels;
      const int index = default_layout()->index_of(it.name());
      ASSERT_GE(index, 0) << it.name();
      EXPECT_EQ(it.channel().type, Imf::FLOAT);
      std::vector<float> values(tile.pixels());
      Imf::FrameBuffer buffer;
      buffer.insert(it.name(), Imf::Slice::Make(Imf::FLOAT, values.data(), header.dataWindow(),
                                                sizeof(float), 58 * sizeof(float)));
      file.setFrameBuffer(buffer);
      file.readPixels(64, 103);
      const auto plane = tile.plane(static_cast<std::size_t>(index));
      EXPECT_THAT(values, testing::ElementsAreArray(plane.begin(), plane.end())) << it.name();
    }
    EXPECT_EQ(channels, default_layout()->size());
  }
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace tessera::image
