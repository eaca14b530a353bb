#include "scenes/report/measure/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/error.hpp"

namespace tessera::report {
namespace {

/// Every colour of every pixel is `value`.
Picture flat(float value, std::int64_t samples = 16, int width = 40, int height = 25) {
  Picture picture;
  picture.name = "flat.exr";
  picture.integrator = "path";
  picture.sampler = "pcg";
  picture.samples = samples;
  picture.light_samples = 1;
  picture.width = width;
  picture.height = height;
  picture.cpu_seconds = value;
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  picture.rgb.fill(std::vector<float>(pixels, value));
  return picture;
}

std::string refusal(const image::FrameImage& frame, const image::Metadata& metadata) {
  try {
    picture_from(image::read_exr(image::encode_exr(frame, metadata)), "p.exr");
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Picture, takes_its_settings_from_the_header_and_the_variance_of_one_sample_from_the_channels) {
  image::FrameImage frame;
  frame.width = 2;
  frame.height = 1;
  frame.samples = {5, 5};
  frame.values.assign(2 * image::channel_count, 0.0F);
  frame.plane(image::G)[1] = 0.5F;
  frame.plane(image::M2_G)[1] = 12;  // (n − 1) times the variance of a sample
  image::Metadata metadata;
  metadata.set("tessera.integrator", "cosine");
  metadata.set("tessera.scene", "5ce");
  metadata.set("tessera.filter", "box");
  metadata.set("tessera.filter_width", 1.0);
  metadata.set("tessera.sampler", "pcg");
  metadata.set("tessera.samples", 5);
  metadata.set("tessera.light_samples", 2);
  metadata.set("tessera.bounces", 3);
  metadata.set("tessera.cpu_seconds", 1.5);
  const Picture picture =
      picture_from(image::read_exr(image::encode_exr(frame, metadata)), "p.exr");
  EXPECT_EQ(picture.integrator, "cosine");
  EXPECT_EQ(picture.sampler, "pcg");
  EXPECT_EQ(picture.samples, 5);
  EXPECT_EQ(picture.light_samples, 2);
  EXPECT_EQ(picture.bounces, 3);
  EXPECT_EQ(picture.cpu_seconds, 1.5);
  EXPECT_EQ(picture.rgb[1][1], 0.5F);
  ASSERT_TRUE(picture.variance.has_value());
  EXPECT_NEAR(*picture.variance, 12.0 / 4 / 6, 1e-6);  // one of six values
  metadata.set("tessera.samples", 6);
  EXPECT_EQ(refusal(frame, metadata), "p.exr: a pixel has 5 of 6 samples: the job had not ended");
  metadata.set("tessera.bounces", "few");
  EXPECT_EQ(refusal(frame, metadata), "p.exr: tessera.bounces is \"few\", expected a number");
}

TEST(Picture, that_is_none_of_ours_is_refused_by_name) {
  image::FrameImage frame;
  frame.width = frame.height = 1;
  frame.samples = {1};
  frame.values.assign(image::channel_count, 0.0F);
  try {
    picture_from(image::read_exr(image::encode_exr(frame, {})), "other.exr");
    FAIL() << "it was taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::bad_input);
    EXPECT_STREQ(
        error.what(),
        "other.exr: the header has no tessera.integrator: is this a picture of Tessera's?");
  }
}

TEST(Cells, hold_the_pictures_that_differ_in_nothing_that_the_header_names) {
  std::vector<Picture> pictures{flat(1, 16), flat(2, 4), flat(3, 16), flat(4, 4), flat(5, 4)};
  pictures[4].light_samples = 2;
  const std::vector<Cell> cells = cells_of(pictures);
  ASSERT_EQ(cells.size(), 3U);
  EXPECT_EQ(cells[0].settings().samples, 4);
  EXPECT_EQ(cells[0].pictures.size(), 2U);
  EXPECT_EQ(cells[1].settings().samples, 16);
  EXPECT_EQ(cells[1].pictures.size(), 2U);
  EXPECT_EQ(cells[2].settings().light_samples, 2);
  EXPECT_EQ(cells[2].pictures.size(), 1U);
}

TEST(Cells, are_parted_by_scene_camera_filter_and_size) {
  std::vector<Picture> pictures(6, flat(1));
  pictures[1].scene = "another";
  pictures[2].camera = "another";
  pictures[3].filter = "tent";
  pictures[4].filter_width = 2;
  pictures[5] = flat(1, 16, 20, 50);
  EXPECT_EQ(cells_of(pictures).size(), 6U);
}

TEST(Means, have_the_standard_error_of_the_spread_between_pictures) {
  const std::vector<Picture> pictures{flat(1), flat(2), flat(3), flat(4)};
  const Mean mean = means_of(cells_of(pictures).front())[1];
  EXPECT_DOUBLE_EQ(mean.value, 2.5);
  EXPECT_DOUBLE_EQ(mean.error, std::sqrt(5.0 / 3 / 4));
  EXPECT_EQ(mean.pictures, 4);
}

TEST(Errors, are_the_mean_squares_of_what_is_off) {
  const std::vector<Picture> pictures{flat(1.5F), flat(0.75F)};
  const Errors errors = errors_of(cells_of(pictures).front(), flat(1));
  const double mse = (0.25 + 0.0625) / 2;
  EXPECT_DOUBLE_EQ(errors.mse, mse);
  EXPECT_NEAR(errors.relative, mse / 1.01, 1e-12);
  EXPECT_NEAR(errors.trimmed, mse / 1.01, 1e-12);
  EXPECT_DOUBLE_EQ(errors.of_mse, (0.25 - 0.0625) / 2);
  EXPECT_DOUBLE_EQ(errors.cpu_seconds, 1.125);
}

TEST(Errors, trimmed_leave_out_one_pixel_in_a_thousand) {
  std::vector<Picture> pictures{flat(1)};
  for (auto& plane : pictures[0].rgb) plane[321] = 11;
  const Errors errors = errors_of(cells_of(pictures).front(), flat(1));
  EXPECT_NEAR(errors.relative, 100 / 1.01 / 1000, 1e-12);
  EXPECT_EQ(errors.trimmed, 0);
  for (auto& plane : pictures[0].rgb) plane[322] = 11;
  EXPECT_GT(errors_of(cells_of(pictures).front(), flat(1)).trimmed, 0.09);
}

TEST(Errors, of_pictures_of_another_size_are_refused) {
  const std::vector<Picture> pictures{flat(1)};
  EXPECT_THROW(errors_of(cells_of(pictures).front(), flat(1, 16, 25, 40)), Error);
  EXPECT_THROW(mean_picture({flat(1), flat(1, 16, 10, 10)}), Error);
  EXPECT_THROW(mean_picture({}), Error);
}

TEST(MeanPicture, is_the_mean_of_each_pixel) {
  Picture one = flat(1);
  one.rgb[2][7] = 4;
  const Picture mean = mean_picture({one, flat(2)});
  EXPECT_FLOAT_EQ(mean.rgb[0][7], 1.5F);
  EXPECT_FLOAT_EQ(mean.rgb[2][7], 3);
}

TEST(Welch, with_two_degrees_of_freedom_has_students_closed_form) {
  // Two means of two pictures each and the same error: 2 degrees of freedom, and for those
  // p = 1 − |t| / √(t² + 2).
  const WelchTest test = welch({1.7, 0.2, 2}, {1.1, 0.2, 2});
  const double t = 0.6 / (0.2 * std::sqrt(2.0));
  EXPECT_NEAR(test.t, t, 1e-12);
  EXPECT_NEAR(test.p, 1 - t / std::sqrt(t * t + 2), 1e-9);
  EXPECT_NEAR(welch({1.1, 0.2, 2}, {1.7, 0.2, 2}).t, -t, 1e-12);
}

TEST(Welch, with_one_mean_that_is_known_has_the_other_ones_degrees_of_freedom) {
  // One degree of freedom is Cauchy's distribution: p = 1 − 2·atan(t)/π.
  const WelchTest test = welch({3, 1, 2}, {0, 0, 50});
  EXPECT_NEAR(test.p, 1 - 2 * std::atan(3.0) / 3.14159265358979, 1e-9);
}

TEST(Welch, without_any_spread_is_a_mistake) {
  EXPECT_THROW(welch({1, 0, 4}, {1, 0, 4}), Error);
  EXPECT_THROW(welch({1, 0.1, 1}, {1, 0.1, 4}), Error);
}

TEST(Sidak, makes_many_tests_one_of_the_level) {
  EXPECT_DOUBLE_EQ(sidak(0.01, 1), 0.01);
  EXPECT_NEAR(1 - std::pow(1 - sidak(0.01, 48), 48), 0.01, 1e-12);
}

}  // namespace
}  // namespace tessera::report
