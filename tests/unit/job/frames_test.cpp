#include "common/job/frames.hpp"

#include <gmock/gmock.h>

#include "common/base/error.hpp"

namespace tessera {
namespace {

std::vector<std::int32_t> numbers(const FrameList& list) {
  std::vector<std::int32_t> out;
  for (std::uint32_t i = 0; i < list.count(); ++i) out.push_back(list.number(i));
  return out;
}

using testing::ElementsAre;
using testing::HasSubstr;

TEST(Frames, are_read_as_people_write_them) {
  EXPECT_THAT(numbers(frames_from_text("7")), ElementsAre(7));
  EXPECT_THAT(numbers(frames_from_text("1-4")), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(numbers(frames_from_text("1-8x3")), ElementsAre(1, 4, 7));
  EXPECT_THAT(numbers(frames_from_text("1,5,10-12")), ElementsAre(1, 5, 10, 11, 12));
  EXPECT_THAT(numbers(frames_from_text("-5--3,0")), ElementsAre(-5, -4, -3, 0));
  EXPECT_EQ(frames_from_text("1-240x2").count(), 120U);
}

TEST(Frames, come_out_ascending_and_each_once) {
  EXPECT_THAT(numbers(frames_from_text("10-12,1,11,5")), ElementsAre(1, 5, 10, 11, 12));
  EXPECT_THAT(numbers(frames_from_text("1-9x2,2-10x2")),
              ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9, 10));
  EXPECT_EQ(frames_from_text("1-9x2,2-10x2"), FrameList(1, 10, 1));
}

TEST(Frames, of_a_list_are_counted_through_its_ranges) {
  const FrameList list = frames_from_text("1,5,10-20x5,100-103");
  for (std::uint32_t i = 0; i < list.count(); ++i) {
    EXPECT_EQ(list.index(list.number(i)), i);
    EXPECT_TRUE(list.contains(list.number(i)));
  }
  EXPECT_EQ(list.first(), 1);
  EXPECT_EQ(list.last(), 103);
  for (const int frame : {0, 2, 11, 21, 99, 104}) EXPECT_FALSE(list.contains(frame)) << frame;
}

TEST(Frames, text_of_a_list_is_short_and_says_the_same) {
  for (const char* text : {"7", "1-240", "1-239x2", "1,5,10-20", "-5--3,0", "1,3", "1-9x4,20-30"}) {
    EXPECT_EQ(text_of(frames_from_text(text)), text);
    EXPECT_EQ(frames_from_text(text_of(frames_from_text(text))), frames_from_text(text));
  }
  EXPECT_EQ(text_of(frames_from_text("1-240x2")), "1-239x2");
  EXPECT_EQ(frames_from_text("1-9x65536"), FrameList(1, 1, 1)) << "one frame has no step";
}

TEST(Frames, that_make_no_sense_are_refused_with_examples) {
  for (const char* text : {"", "a", "1-", "4-1", "1-5x0", "1-5x", "1,", ",1", "1 ,2", "1-5x2x3",
                           "1000001", "1-2000000", "5x2"}) {
    try {
      static_cast<void>(frames_from_text(text));
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::bad_input);
      EXPECT_THAT(error.what(), HasSubstr("1-240x2"));
    }
  }
}

}  // namespace
}  // namespace tessera
