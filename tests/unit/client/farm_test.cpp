#include "client/farm.hpp"

#include <gtest/gtest.h>

#include "tests/unit/client/support.hpp"

namespace tessera::client {
namespace {

TEST(ServerAddresses, are_read_from_the_coordinators_line) {
  const ServerAddresses addresses =
      addresses_from(R"({"http":"127.0.0.1:4711","listen":"127.0.0.1:4712","more":1})");
  EXPECT_EQ(addresses.http, "127.0.0.1:4711");
  EXPECT_EQ(addresses.listen, "127.0.0.1:4712");
}

TEST(ServerAddresses, another_line_is_an_error_that_shows_it) {
  for (const char* line :
       {"", "hello", "[]", "{}", R"({"http": 1, "listen": "a"})", R"({"http": "a"})"}) {
    const Error error = error_of([&] { (void)addresses_from(line); });
    EXPECT_EQ(error.kind(), ErrorKind::failed) << line;
    EXPECT_NE(error.message().find(line), std::string::npos);
  }
}

TEST(Processors, there_is_at_least_one) { EXPECT_GE(processors(), 1); }

}  // namespace
}  // namespace tessera::client
