#include "client/output.hpp"

#include <gtest/gtest.h>

#include "tests/unit/client/support.hpp"

namespace tessera::client {
namespace {

TEST(Output, the_ending_says_the_format) {
  const TemporaryFolder folder;
  EXPECT_EQ(check_output(folder.path() / "a.exr"), PictureFormat::exr);
  EXPECT_EQ(check_output(folder.path() / "a.b.PNG"), PictureFormat::png);
}

TEST(Output, what_cannot_be_written_is_refused_before_anything_renders) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "d.exr");
  for (const auto& file : {folder.path() / "a.jpg", folder.path() / "a",
                           folder.path() / "no" / "a.exr", folder.path() / "d.exr"}) {
    const Error error = error_of([&] { (void)check_output(file); });
    EXPECT_EQ(error.kind(), ErrorKind::bad_input) << file;
    EXPECT_EQ(error.place().key, "--output");
  }
}

TEST(Output, the_route_has_the_frame_and_for_png_the_exposure) {
  EXPECT_EQ(picture_target(3, 12, PictureFormat::exr, 1.5), "/v1/jobs/3/frames/12/image.exr");
  EXPECT_EQ(picture_target(3, -1, PictureFormat::png, 0), "/v1/jobs/3/frames/-1/image.png");
  EXPECT_EQ(picture_target(3, 1, PictureFormat::png, -1.5),
            "/v1/jobs/3/frames/1/image.png?exposure=-1.5");
}

TEST(Output, a_view_is_named_and_the_nearest_is_said) {
  EXPECT_EQ(view_from("filmic"), image::View::filmic);
  const Error error = error_of([&] { (void)view_from("filmc"); });
  EXPECT_EQ(error.place().key, "--view");
  EXPECT_NE(error.message().find("filmic"), std::string::npos);
}

}  // namespace
}  // namespace tessera::client
