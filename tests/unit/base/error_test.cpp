#include "common/base/error.hpp"

#include <gtest/gtest.h>

#include "common/base/log.hpp"

namespace tessera {
namespace {

TEST(Error, tells_the_place_and_then_the_message) {
  const Error error(ErrorKind::bad_input, "expected a number",
                    {.file = "a.json", .line = 3, .column = 7, .key = "film.width"});
  EXPECT_STREQ(error.what(), "a.json:3:7: film.width: expected a number");
  EXPECT_EQ(error.message(), "expected a number");
  EXPECT_EQ(error.kind(), ErrorKind::bad_input);
  EXPECT_EQ(error.place().line, 3);
}

TEST(Error, leaves_out_what_it_does_not_know_of_the_place) {
  EXPECT_STREQ(Error(ErrorKind::failed, "no").what(), "no");
  EXPECT_STREQ(Error(ErrorKind::failed, "no", {.file = "f"}).what(), "f: no");
  EXPECT_STREQ(Error(ErrorKind::failed, "no", {.key = "k"}).what(), "k: no");
  EXPECT_STREQ(Error(ErrorKind::failed, "no", {.line = 2, .column = 4}).what(), "line 2:4: no");
}

TEST(Error, can_be_shown_whatever_stood_in_the_input) {
  const Error error(ErrorKind::bad_input, "found \"a\x1b[2J\xff\"\nand more ü",
                    {.file = "b\xc0", .key = "c\x7f"});
  EXPECT_STREQ(error.what(), "b?: c?: found \"a?[2J?\"\nand more ü");
  EXPECT_EQ(error.message(), "found \"a?[2J?\"\nand more ü");
}

TEST(ErrorKind, tells_a_full_disk_and_a_quota_from_other_trouble) {
  for (const auto* category : {&std::generic_category(), &std::system_category()}) {
    EXPECT_EQ(kind_of({ENOSPC, *category}), ErrorKind::no_room);
    EXPECT_EQ(kind_of({EDQUOT, *category}), ErrorKind::no_room);
    EXPECT_EQ(kind_of({ENOENT, *category}), ErrorKind::not_found);
    EXPECT_EQ(kind_of({EIO, *category}), ErrorKind::failed);
    EXPECT_EQ(kind_of({EROFS, *category}), ErrorKind::failed);
  }
}

TEST(ExitCode, is_what_scripts_rely_on) {
  EXPECT_EQ(exit_code(ErrorKind::bad_input), 2);
  EXPECT_EQ(exit_code(ErrorKind::too_large), 2);
  EXPECT_EQ(exit_code(ErrorKind::unreachable), 3);
  EXPECT_EQ(exit_code(ErrorKind::refused), 4);
  EXPECT_EQ(exit_code(ErrorKind::not_found), 1);
  EXPECT_EQ(exit_code(ErrorKind::conflict), 1);
  EXPECT_EQ(exit_code(ErrorKind::no_room), 1);
  EXPECT_EQ(exit_code(ErrorKind::failed), 1);
}

TEST(LogLevel, is_known_by_name_and_another_name_gets_the_nearest) {
  EXPECT_EQ(log::level_from("debug"), log::Level::debug);
  EXPECT_EQ(log::level_from("error"), log::Level::error);
  try {
    log::level_from("inof");
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(),
                 "unknown log level \"inof\"; did you mean \"info\"? (expected one of: debug, "
                 "info, warn, error)");
  }
}

}  // namespace
}  // namespace tessera
