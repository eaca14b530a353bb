#include "client/child.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <memory>

#include "tests/unit/client/support.hpp"

namespace tessera::client {
namespace {

using std::chrono::seconds;

class ChildTest : public testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<Child> shell(const std::string& script) const {
    return std::make_unique<Child>("the shell", "/bin/sh", std::vector<std::string>{"-c", script},
                                   folder_.path() / "log");
  }
  static void await_end(Child& child) {
    const auto end = std::chrono::steady_clock::now() + seconds(20);
    while (child.running() && std::chrono::steady_clock::now() < end) {
    }
    ASSERT_FALSE(child.running());
  }
  TemporaryFolder folder_;
};

TEST_F(ChildTest, its_first_line_is_read_and_what_follows_does_not_matter) {
  const auto child = shell("echo one; echo two; sleep 30");
  EXPECT_EQ(child->first_line(seconds(20)), "one");
  EXPECT_TRUE(child->running());
}

TEST_F(ChildTest, one_that_ends_without_a_line_gives_none_at_once) {
  const auto child = shell("echo reason >&2; exit 7");
  const auto start = std::chrono::steady_clock::now();
  EXPECT_FALSE(child->first_line(seconds(60)).has_value());
  EXPECT_LT(std::chrono::steady_clock::now() - start, seconds(30));
  await_end(*child);
  EXPECT_EQ(child->epitaph(), "the shell ended with code 7\n  reason");
}

TEST_F(ChildTest, silence_is_given_up_after_the_time) {
  const auto child = shell("sleep 30");
  EXPECT_FALSE(child->first_line(std::chrono::milliseconds(50)).has_value());
}

TEST_F(ChildTest, a_signal_is_named) {
  const auto child = shell("kill -SEGV $$");
  await_end(*child);
  EXPECT_NE(child->epitaph().find("the shell was killed by signal 11"), std::string::npos);
}

TEST_F(ChildTest, one_that_is_asked_ends_in_order_and_one_that_will_not_is_killed) {
  const auto polite = shell("trap 'exit 3' TERM; echo up; while :; do sleep 0.01; done");
  ASSERT_TRUE(polite->first_line(seconds(20)).has_value());
  polite->ask_to_end();
  polite->end_within(seconds(20));
  EXPECT_NE(polite->epitaph().find("ended with code 3"), std::string::npos);

  const auto stubborn = shell("trap '' TERM; echo up; while :; do sleep 0.01; done");
  ASSERT_TRUE(stubborn->first_line(seconds(20)).has_value());
  stubborn->ask_to_end();
  stubborn->end_within(std::chrono::milliseconds(100));
  EXPECT_FALSE(stubborn->running());
  EXPECT_NE(stubborn->epitaph().find("killed by signal 9"), std::string::npos);
}

TEST_F(ChildTest, variables_of_ours_are_not_handed_on_and_others_are) {
  setenv("TESSERA_TOKEN", "secret", 1);
  setenv("OTHER_THING", "kept", 1);
  const auto child = shell("echo \"$TESSERA_TOKEN/$OTHER_THING\"");
  EXPECT_EQ(child->first_line(seconds(20)), "/kept");
  unsetenv("TESSERA_TOKEN");
}

TEST_F(ChildTest, a_program_that_is_not_there_ends_with_code_127) {
  Child child("nobody", folder_.path() / "none", {}, folder_.path() / "log");
  await_end(child);
  EXPECT_EQ(child.epitaph(), "nobody ended with code 127\n  cannot be executed");
}

}  // namespace
}  // namespace tessera::client
