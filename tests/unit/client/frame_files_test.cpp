#include "client/frame_files.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "client/job_options.hpp"
#include "tests/unit/client/support.hpp"

namespace tessera::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(FrameFiles, number_takes_the_place_of_the_signs_filled_up_with_zeros) {
  EXPECT_EQ(file_of_frame("out/a-####.exr", 7), "out/a-0007.exr");
  EXPECT_EQ(file_of_frame("out/a-####.exr", 12345), "out/a-12345.exr");
  EXPECT_EQ(file_of_frame("#.png", 12), "12.png");
  EXPECT_EQ(file_of_frame("a.##.png", -3), "a.-03.png");
  EXPECT_EQ(file_of_frame("o#t/plain.exr", 9), "o#t/plain.exr") << "a folder's name is a name";
}

TEST(FrameFiles, several_frames_need_a_place_for_their_numbers) {
  check_frame_files("a.exr", 1);
  check_frame_files("a-##.exr", 1);
  check_frame_files("a-##.exr", 240);
  const Error none = error_of([] { check_frame_files("x/a.exr", 240); });
  EXPECT_EQ(none.kind(), ErrorKind::bad_input);
  EXPECT_EQ(none.place().key, "--output");
  EXPECT_THAT(none.what(), HasSubstr("240 frames"));
  EXPECT_THAT(error_of([] { check_frame_files("a-##-##.exr", 1); }).what(), HasSubstr("several"));
}

TEST(FrameFiles, frames_are_read_from_the_job_of_this_server_and_of_an_older_one) {
  const Json list = Json::parse(
      R"({"frames": {"first": 1, "last": 9, "step": null, "count": 4,
          "ranges": [{"first": 1, "last": 1, "step": 1}, {"first": 5, "last": 9, "step": 2}]}})");
  EXPECT_EQ(frames_of_job(list), frames_from_text("1,5-9x2"));
  const Json old = Json::parse(R"({"frames": {"first": 3, "last": 7, "step": 2, "count": 3}})");
  EXPECT_EQ(frames_of_job(old), frames_from_text("3-7x2"));
  EXPECT_EQ(error_of([] { (void)frames_of_job(Json::object()); }).kind(), ErrorKind::failed);
}

TEST(FrameFiles, those_that_have_a_picture_are_told_from_the_others) {
  const Json job = Json::parse(R"({"pictures": [{"frame": 3, "version": 9}, {"frame": 7}]})");
  EXPECT_THAT(frames_with_picture(job, frames_from_text("3-7x2")), ElementsAre(3, 7));
}

}  // namespace
}  // namespace tessera::client
