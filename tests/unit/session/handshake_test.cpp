#include "server/session/handshake.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera::server {
namespace {

using testing::HasSubstr;

wire::Hello good() {
  wire::Hello hello;
  hello.token = "secret";
  hello.name = "node 7";
  hello.identity = "0123456789abcdef0123456789ABCDEF";
  hello.threads = 8;
  return hello;
}

TEST(Hello, ThatShowsEverythingIsTaken) {
  EXPECT_FALSE(check_hello(good(), "secret"));
  EXPECT_FALSE(check_hello(good(), ""));  // none is needed
}

TEST(Hello, TokenIsLookedAtBeforeAnythingElse) {
  wire::Hello hello = good();
  hello.token = "wrong";
  hello.identity = "x";
  const auto refused = check_hello(hello, "secret");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, "token");
  EXPECT_EQ(refused->reason, "the token is not this coordinator's");
  hello.token.clear();
  EXPECT_EQ(check_hello(hello, "secret")->reason,
            "this coordinator asks for a token, and none was shown");
}

TEST(Hello, InsaneOnesAreRefusedByTheirKey) {
  wire::Hello hello = good();
  hello.identity.back() = 'g';
  EXPECT_EQ(check_hello(hello, "secret")->reason, "identity: expected 32 hexadecimal digits");
  hello = good();
  hello.identity += "0";
  EXPECT_EQ(check_hello(hello, "secret")->code, "protocol");
  hello = good();
  hello.name = "two\nlines";
  EXPECT_THAT(check_hello(hello, "secret")->reason, HasSubstr("name: expected"));
  hello = good();
  hello.threads = 0;
  EXPECT_EQ(check_hello(hello, "secret")->reason, "threads: expected 1 to 4096, found 0");
}

TEST(BlobUrl, IsMadeFromTheAddressThatWasDialled) {
  EXPECT_EQ(blob_url_for("", "10.1.2.3:8421", 8420), "http://10.1.2.3:8420");
  EXPECT_EQ(blob_url_for("", "[::1]:8421", 99), "http://[::1]:99");
  EXPECT_EQ(blob_url_for("https://farm.example", "10.1.2.3:8421", 8420), "https://farm.example");
}

TEST(Refusal, NamesAnotherVersionAsSuch) {
  EXPECT_EQ(refusal_of(wire::FrameError(wire::FrameProblem::version, "x")).code, "version");
  EXPECT_EQ(refusal_of(wire::FrameError(wire::FrameProblem::http, "x")).code, "protocol");
}

}  // namespace
}  // namespace tessera::server
