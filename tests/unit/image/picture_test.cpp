#include "common/image/picture.hpp"

#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfTiledOutputFile.h>
#include <gmock/gmock.h>
#include <half.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <random>

#include "common/base/error.hpp"
#include "common/base/files.hpp"

namespace tessera::image {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

FrameImage make_frame(int width, int height, unsigned seed = 1) {
  FrameImage frame{.width = width, .height = height, .values = {}, .samples = {}};
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, 4);
  frame.values.resize(channel_count * frame.pixels());
  for (float& value : frame.values) value = uniform(random);
  for (std::size_t i = 0; i < frame.pixels(); ++i)
    frame.samples.push_back(static_cast<std::uint32_t>(random() % 300));
  return frame;
}

Metadata some_metadata() {
  Metadata metadata;
  metadata.set("software", std::string("Tessera 1.2.3"));
  metadata.set("comments", std::string());
  metadata.set("tessera.seed", std::string("9223372036854775807"));
  metadata.set("tessera.samples", std::int32_t{256});
  metadata.set("tessera.render_seconds", 12.25);
  metadata.set("utcOffset", 0.0F);
  metadata.set("worldToCamera", Matrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1});
  return metadata;
}

std::filesystem::path temporary(const char* name) {
  return std::filesystem::path(testing::TempDir()) / name;
}

class Picture : public testing::TestWithParam<std::tuple<int, int, Compression>> {};

TEST_P(Picture, is_read_back_with_every_channel_by_name_and_every_bit) {
  const auto& [width, height, compression] = GetParam();
  const FrameImage frame = make_frame(width, height);
  const ExrImage back = read_exr(encode_exr(frame, some_metadata(), compression));
  EXPECT_EQ(back.width, width);
  EXPECT_EQ(back.height, height);
  EXPECT_THAT(back.channels,
              ElementsAre("A", "B", "G", "N.X", "N.Y", "N.Z", "R", "Z", "albedo.B", "albedo.G",
                          "albedo.R", "samples", "variance.B", "variance.G", "variance.R"));
  for (const Channel& channel : default_layout()->channels()) {
    if (channel.merge == Merge::moment2) continue;
    const auto written =
        frame.plane(static_cast<std::size_t>(default_layout()->index_of(channel.name)));
    const auto read = back.plane(channel.name);
    EXPECT_EQ(0, std::memcmp(written.data(), read.data(), written.size_bytes())) << channel.name;
  }
  for (std::size_t i = 0; i < frame.pixels(); ++i) {
    const double n = frame.samples[i];
    EXPECT_EQ(back.plane("samples")[i], static_cast<float>(n));
    const double expected = n < 2 ? 0 : static_cast<double>(frame.plane(M2_G)[i]) / n / (n - 1);
    EXPECT_NEAR(back.plane("variance.G")[i], expected, 1e-6 * expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, Picture,
                         testing::Combine(testing::Values(1, 37), testing::Values(1, 16, 17, 50),
                                          testing::Values(Compression::none, Compression::zip)));

TEST(Picture, that_is_flat_gets_smaller_and_keeps_its_bits) {
  FrameImage frame = make_frame(64, 64);
  std::fill(frame.values.begin(), frame.values.end(), 0.25F);
  const auto packed = encode_exr(frame, {}, Compression::zip),
             raw = encode_exr(frame, {}, Compression::none);
  EXPECT_LT(packed.size() * 4, raw.size());
  EXPECT_EQ(difference(read_exr(packed), read_exr(raw)), std::nullopt);
}

TEST(Picture, has_equal_bytes_for_equal_content_and_metadata_and_others_for_others) {
  const auto bytes = encode_exr(make_frame(40, 30), some_metadata());
  EXPECT_EQ(bytes, encode_exr(make_frame(40, 30), some_metadata()));
  EXPECT_NE(bytes, encode_exr(make_frame(40, 30, 2), some_metadata()));
  Metadata other = some_metadata();
  other.set("tessera.samples", std::int32_t{257});
  EXPECT_NE(bytes, encode_exr(make_frame(40, 30), other));
}

TEST(Picture, says_how_it_was_made_also_to_OpenEXRs_own_reader) {
  const auto path = temporary("tessera_picture_test.exr");
  write_file_atomically(path, encode_exr(make_frame(20, 10), some_metadata()));
  {
    Imf::InputFile file(path.c_str());
    const Imf::Header& header = file.header();
    EXPECT_EQ(header.dataWindow(), Imath::Box2i({0, 0}, {19, 9}));
    EXPECT_EQ(header.displayWindow(), Imath::Box2i({0, 0}, {19, 9}));
    EXPECT_EQ(Imf::comments(header), "");
    EXPECT_EQ(Imf::worldToCamera(header)[3][1], 6.0F);
    EXPECT_EQ(Imf::chromaticities(header).red, Imath::V2f(0.64F, 0.33F));
    EXPECT_EQ(Imf::chromaticities(header).white, Imath::V2f(0.3127F, 0.3290F));
  }
  EXPECT_EQ(read_exr_file(path).metadata.text("tessera.seed"), "9223372036854775807");
  std::filesystem::remove(path);
}

/// Rows [5, 5 + height) of a film that is wider and higher, each value its row's number.
class Window : public FrameRows {
 public:
  [[nodiscard]] int film_width() const override { return 60; }
  [[nodiscard]] int film_height() const override { return 50; }
  [[nodiscard]] Rect window() const override { return {7, 5, 20, 40}; }
  [[nodiscard]] const ChannelLayout& layout() const override { return *default_layout(); }
  void values(std::size_t, int y, std::span<float> row) const override {
    std::fill(row.begin(), row.end(), static_cast<float>(5 + y));
  }
  void samples(int, std::span<std::uint32_t> row) const override {
    std::fill(row.begin(), row.end(), 1U);
  }
};

TEST(Picture, of_a_part_of_the_film_says_where_in_it_it_lies) {
  const auto path = temporary("tessera_window_test.exr");
  Metadata metadata;
  metadata.set_pixel_aspect(1.5F);
  for (const Compression compression : {Compression::zip, Compression::none}) {
    write_file_atomically(path, encode_exr(Window(), metadata, compression));
    {
      Imf::InputFile file(path.c_str());
      EXPECT_EQ(file.header().dataWindow(), Imath::Box2i({7, 5}, {26, 44}));
      EXPECT_EQ(file.header().displayWindow(), Imath::Box2i({0, 0}, {59, 49}));
      EXPECT_EQ(file.header().pixelAspectRatio(), 1.5F);
    }
    const ExrImage back = read_exr_file(path);
    for (std::size_t y = 0; y < 40; ++y)
      EXPECT_EQ(back.plane("G")[20 * y + 3], static_cast<float>(5 + y));
  }
  std::filesystem::remove(path);
}

TEST(Metadata, comes_back_as_it_was_written) {
  Metadata written = some_metadata();
  written.set_pixel_aspect(0.5F);
  const Metadata read = read_exr(encode_exr(make_frame(2, 2), written)).metadata;
  EXPECT_EQ(read.pixel_aspect(), 0.5F);
  EXPECT_EQ(read.attributes().size(), written.attributes().size());
  for (const auto& attribute : written.attributes()) {
    ASSERT_NE(read.find(attribute.name), nullptr) << attribute.name;
    EXPECT_EQ(*read.find(attribute.name), attribute.value) << attribute.name;
  }
}

TEST(Metadata, keeps_the_order_of_first_setting_and_the_last_value) {
  Metadata metadata;
  metadata.set("b", 1.5);
  metadata.set("a", std::string("x"));
  metadata.set("b", std::int32_t{2});
  ASSERT_EQ(metadata.attributes().size(), 2U);
  EXPECT_EQ(metadata.attributes()[0].name, "b");
  EXPECT_EQ(metadata.text("b"), "2");
  EXPECT_EQ(metadata.text("c"), "");
  EXPECT_EQ(metadata.find("c"), nullptr);
}

TEST(Metadata, refuses_names_that_say_how_the_file_is_laid_out) {
  Metadata metadata;
  for (const char* name :
       {"", "channels", "dataWindow", "chromaticities", "a-name-that-is-longer-than-31-bytes"})
    EXPECT_THROW(metadata.set(name, 1.0), Error) << name;
  EXPECT_TRUE(metadata.attributes().empty());
}

TEST(Metadata, of_a_job_names_scene_camera_seed_samples_integrator_sampler_and_filter) {
  JobSpec job;
  job.name = "night";
  job.bundle = digest_of("scene");
  job.camera = "front";
  job.render.samples = 100;
  job.render.seed = 7;
  Metadata metadata = metadata_of(job, 3);
  EXPECT_EQ(metadata.text("tessera.scene"), job.bundle.hex());
  EXPECT_EQ(metadata.text("tessera.camera"), "front");
  EXPECT_EQ(metadata.text("tessera.frame"), "3");
  EXPECT_EQ(metadata.text("tessera.samples"), "100");
  EXPECT_EQ(metadata.text("tessera.seed"), "7");
  EXPECT_EQ(metadata.text("tessera.integrator"), "path");
  EXPECT_EQ(metadata.text("tessera.sampler"), "sobol_owen");
  EXPECT_EQ(metadata.text("tessera.filter"), "blackman_harris");
  EXPECT_THAT(metadata.text("software"), testing::StartsWith("Tessera "));
  set_date(metadata, 1'000'000'000'500);
  EXPECT_EQ(metadata.text("capDate"), "2001:09:09 01:46:40");
}

TEST(Metadata, of_a_job_says_how_light_was_clamped_only_where_it_was) {
  JobSpec job;
  const auto of_the_file = [&] {
    return read_exr(encode_exr(make_frame(2, 2), metadata_of(job, 1))).metadata;
  };
  const auto value = [](const Metadata& metadata, const char* name) {
    const AttributeValue* const found = metadata.find(name);
    return found == nullptr ? -1 : std::get<double>(*found);
  };
  EXPECT_EQ(of_the_file().find("tessera.clamp_direct"), nullptr);
  EXPECT_EQ(of_the_file().find("tessera.clamp_indirect"), nullptr);
  job.render.clamp_direct = 5;
  EXPECT_EQ(value(of_the_file(), "tessera.clamp_direct"), 5);
  EXPECT_EQ(of_the_file().find("tessera.clamp_indirect"), nullptr);
  job.render.clamp_indirect = 0.3;
  EXPECT_EQ(value(of_the_file(), "tessera.clamp_direct"), 5);
  EXPECT_EQ(value(of_the_file(), "tessera.clamp_indirect"), 0.3);
  job.render.clamp_direct = 0;
  EXPECT_EQ(of_the_file().find("tessera.clamp_direct"), nullptr);
}

TEST(ReadExr, reads_half_floats_and_tiles_and_a_window_that_is_not_at_the_corner) {
  const auto path = temporary("tessera_half_test.exr");
  const Imath::Box2i window({-3, 2}, {4, 7});
  std::vector<half> values;
  for (int i = 0; i < 8 * 6; ++i) values.emplace_back(static_cast<float>(i) / 8);
  for (const bool tiled : {false, true}) {
    Imf::Header header(Imath::Box2i({0, 0}, {15, 15}), window);
    header.channels().insert("Y", Imf::Channel(Imf::HALF));
    header.compression() = Imf::PIZ_COMPRESSION;
    Imf::FrameBuffer buffer;
    buffer.insert(
        "Y", Imf::Slice::Make(Imf::HALF, values.data(), window, sizeof(half), 8 * sizeof(half)));
    if (tiled) {
      header.setTileDescription(Imf::TileDescription(4, 4));
      Imf::TiledOutputFile file(path.c_str(), header);
      file.setFrameBuffer(buffer);
      file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
    } else {
      Imf::OutputFile file(path.c_str(), header);
      file.setFrameBuffer(buffer);
      file.writePixels(6);
    }
    const ExrImage image = read_exr_file(path);
    EXPECT_EQ(image.width, 8);
    EXPECT_EQ(image.height, 6);
    for (std::size_t i = 0; i < values.size(); ++i)
      EXPECT_EQ(image.plane("Y")[i], static_cast<float>(i) / 8);
  }
  std::filesystem::remove(path);
}

TEST(ReadExr, names_the_nearest_channel_for_one_that_is_not_there) {
  const ExrImage image = read_exr(encode_exr(make_frame(2, 2), {}));
  EXPECT_FALSE(image.has("albedo.X"));
  try {
    static_cast<void>(image.plane("variance.X"));
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::not_found);
    EXPECT_THAT(error.what(), HasSubstr("did you mean \"variance."));
  }
}

TEST(ReadExr, refuses_truncated_and_damaged_files_by_the_name_given) {
  const auto whole = encode_exr(make_frame(5, 20), some_metadata());
  for (std::size_t length = 0; length < whole.size(); length += 7) {
    const std::vector<std::byte> part(whole.begin(),
                                      whole.begin() + static_cast<std::ptrdiff_t>(length));
    try {
      read_exr(part, "half.exr");
      ADD_FAILURE() << length;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::bad_input);
      EXPECT_EQ(error.place().file, "half.exr") << error.what();
    }
  }
  std::mt19937 random(5);
  for (int round = 0; round < 500; ++round) {
    auto bytes = whole;
    for (int i = 0; i < 4; ++i) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    try {
      read_exr(bytes);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::bad_input) << error.what();
    }
  }
}

TEST(ReadExr, refuses_a_small_file_that_says_it_is_huge_before_memory_is_taken) {
  auto bytes = encode_exr(make_frame(5, 20), {});
  const std::string_view key("dataWindow\0box2i\0", 17);
  const auto raw = std::as_bytes(std::span(key));
  const auto found = std::search(bytes.begin(), bytes.end(), raw.begin(), raw.end());
  ASSERT_NE(found, bytes.end());
  const std::array<std::int32_t, 2> far{29'999, 29'999};
  std::memcpy(&*found + key.size() + 4 + 8, far.data(), sizeof far);
  try {
    read_exr(bytes);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("a picture of 30000 by 30000 with 15 channels is beyond the limits"));
  }
}

TEST(ReadExr, says_which_file_is_not_there) {
  try {
    read_exr_file("/nonexistent/picture.exr");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::not_found);
    EXPECT_THAT(error.what(), HasSubstr("/nonexistent/picture.exr"));
  }
}

TEST(Difference, is_nothing_between_equal_pictures_whatever_their_headers_say) {
  EXPECT_EQ(difference(read_exr(encode_exr(make_frame(9, 8), some_metadata())),
                       read_exr(encode_exr(make_frame(9, 8), {}))),
            std::nullopt);
}

TEST(Difference, of_one_bit_is_found_and_told_by_channel_and_pixel) {
  FrameImage frame = make_frame(9, 8);
  frame.plane(G)[9 * 3 + 2] = 0.5F;
  const ExrImage one = read_exr(encode_exr(frame, {}));
  frame.plane(G)[9 * 3 + 2] = std::nextafter(0.5F, 1.0F);
  const auto told = difference(one, read_exr(encode_exr(frame, {})));
  ASSERT_TRUE(told);
  EXPECT_THAT(*told, testing::StartsWith("G at pixel 2,3 is 0.5 in one picture"));
  EXPECT_THAT(*told, testing::EndsWith("(1 values differ)"));
}

TEST(Difference, sees_the_sign_of_zero_and_other_sizes_and_channels) {
  FrameImage frame = make_frame(3, 3);
  frame.plane(B)[0] = 0.0F;
  const ExrImage zero = read_exr(encode_exr(frame, {}));
  frame.plane(B)[0] = -0.0F;
  EXPECT_TRUE(difference(zero, read_exr(encode_exr(frame, {}))));
  EXPECT_EQ(difference(zero, read_exr(encode_exr(make_frame(3, 4), {}))),
            "one picture is 3x3, the other 3x4");
  ExrImage lacking = zero;
  lacking.channels.back() = "variance.Q";
  EXPECT_EQ(difference(zero, lacking), "channel variance.Q is in one picture only");
}

TEST(Difference, does_not_look_at_diagnostic_channels) {
  ExrImage a{.width = 1, .height = 1, .channels = {"R", "time"}, .values = {1, 2}, .metadata = {}};
  ExrImage b{
      .width = 1, .height = 1, .channels = {"R", "worker"}, .values = {1, 3}, .metadata = {}};
  EXPECT_EQ(difference(a, b), std::nullopt);
  b.values[0] = 4;
  EXPECT_TRUE(difference(a, b));
}

}  // namespace
}  // namespace tessera::image
