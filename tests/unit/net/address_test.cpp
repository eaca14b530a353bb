#include "common/net/address.hpp"

#include <gtest/gtest.h>

#include <string>

#include "common/base/error.hpp"
#include "common/net/token.hpp"

namespace tessera::net {
namespace {

TEST(Address, host_and_port_are_read_in_every_form) {
  EXPECT_EQ(parse_address("127.0.0.1:8421", 1), (Address{"127.0.0.1", 8421}));
  EXPECT_EQ(parse_address("farm.example:0", 1), (Address{"farm.example", 0}));
  EXPECT_EQ(parse_address("[::1]:8421", 1), (Address{"::1", 8421}));
  EXPECT_EQ(parse_address("[fe80::1]", 77), (Address{"fe80::1", 77}));
  EXPECT_EQ(parse_address("localhost", 77), (Address{"localhost", 77}));
}

TEST(Address, text_reads_back) {
  for (const Address& address :
       {Address{"::1", 8421}, Address{"a.b", 1}, Address{"10.0.0.1", 65535}})
    EXPECT_EQ(parse_address(address.text(), 0), address);
  EXPECT_EQ((Address{"::1", 80}).text(), "[::1]:80");
}

TEST(Address, what_is_no_address_is_refused_with_its_text) {
  for (const std::string text :
       {"", ":80", "a:", "a:65536", "a:-1", "a:1x", "::1", "::1:80", "[::1", "[::1]80", "[a]:1",
        "a b:1", "http://a:1", "a/b", "u@h:1", "a:b:c"}) {
    try {
      parse_address(text, 1);
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::bad_input);
      EXPECT_NE(std::string(error.what()).find('"' + text + '"'), std::string::npos);
    }
  }
}

TEST(Address, loopback_is_told_from_the_rest) {
  for (const char* host : {"localhost", "127.0.0.1", "127.8.9.10", "::1", "::ffff:127.0.0.1"})
    EXPECT_TRUE(is_loopback(host)) << host;
  for (const char* host : {"0.0.0.0", "::", "10.0.0.1", "128.0.0.1", "localhost.evil.example",
                           "127.0.0.1.evil.example", "", "::ffff:10.0.0.1"})
    EXPECT_FALSE(is_loopback(host)) << host;
}

TEST(Token, only_the_wanted_token_is_admitted_and_none_wanted_admits_all) {
  EXPECT_TRUE(token_admits("secret", "secret"));
  for (const char* shown : {"", "secre", "secrets", "Secret", "xxxxxx"})
    EXPECT_FALSE(token_admits("secret", shown)) << shown;
  EXPECT_TRUE(token_admits("", ""));
  EXPECT_TRUE(token_admits("", "anything"));
}

TEST(Token, bearer_tokens_are_found_in_a_header) {
  EXPECT_EQ(bearer_token("Bearer abc"), "abc");
  EXPECT_EQ(bearer_token("bearer  abc "), "abc");
  for (const char* header : {"", "Bearer", "Bearer ", "Basic abc", "abc"})
    EXPECT_EQ(bearer_token(header), "") << header;
}

TEST(Token, new_tokens_differ_and_have_256_bits) {
  EXPECT_EQ(new_token().size(), 64U);
  EXPECT_NE(new_token(), new_token());
}

}  // namespace
}  // namespace tessera::net
