#include "common/base/names.hpp"

#include <gtest/gtest.h>

#include <set>

#include "common/base/random.hpp"

namespace tessera {
namespace {

TEST(NearestName, finds_one_slip_in_a_short_name_and_several_in_a_long_one) {
  const std::vector<std::string_view> names{"box", "tent", "gaussian", "blackman_harris"};
  EXPECT_EQ(nearest_name("bok", names), "box");
  EXPECT_EQ(nearest_name("bxo", names), "box") << "a swap of neighbours is one slip";
  EXPECT_EQ(nearest_name("tnet", names), "tent");
  EXPECT_EQ(nearest_name("blackmanharris", names), "blackman_harris");
  EXPECT_EQ(nearest_name("gausian", names), "gaussian");
}

TEST(NearestName, finds_nothing_where_nothing_is_near) {
  const std::vector<std::string_view> names{"box", "tent"};
  EXPECT_EQ(nearest_name("mitchell", names), "");
  EXPECT_EQ(nearest_name("", {}), "");
  EXPECT_EQ(nearest_name(std::string(100'000, 'b'), names), "");
}

TEST(UnknownName, says_kind_name_nearest_and_all_valid_names) {
  EXPECT_EQ(unknown_name("filter", "tnet", {"box", "tent"}),
            "unknown filter \"tnet\"; did you mean \"tent\"? (expected one of: box, tent)");
  EXPECT_EQ(unknown_name("filter", "sinc", {"box", "tent"}),
            "unknown filter \"sinc\" (expected one of: box, tent)");
}

TEST(UnknownName, shows_at_most_64_bytes_of_what_came_from_outside) {
  const std::string text = unknown_name("key", std::string(1000, 'x'), {"a"});
  EXPECT_LT(text.size(), 120U);
}

TEST(PlainName, has_1_to_128_bytes_of_UTF8_without_control_characters) {
  EXPECT_TRUE(is_plain_name("a"));
  EXPECT_TRUE(is_plain_name("nuit étoilée 夜"));
  EXPECT_TRUE(is_plain_name(std::string(128, 'n')));
  EXPECT_FALSE(is_plain_name(""));
  EXPECT_FALSE(is_plain_name(std::string(129, 'n')));
  EXPECT_FALSE(is_plain_name("a\nb"));
  EXPECT_FALSE(is_plain_name(std::string_view("a\0b", 3)));
  EXPECT_FALSE(is_plain_name("\x7f"));
  EXPECT_FALSE(is_plain_name("\xff"));
}

TEST(Utf8, knows_the_first_and_last_of_each_length_and_refuses_what_the_standard_refuses) {
  for (const char* good :
       {"", "\x7f", "\xc2\x80", "\xdf\xbf", "\xe0\xa0\x80", "\xed\x9f\xbf", "\xee\x80\x80",
        "\xef\xbf\xbf", "\xf0\x90\x80\x80", "\xf4\x8f\xbf\xbf", "a\xc3\xa9z"})
    EXPECT_TRUE(is_utf8(good)) << good;
  for (const char* bad :
       {"\x80", "\xc0\x80", "\xc1\xbf", "\xc3", "\xc3z", "\xe0\x9f\xbf", "\xed\xa0\x80", "\xe4\xb8",
        "\xf0\x8f\xbf\xbf", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xff"})
    EXPECT_FALSE(is_utf8(bad)) << bad;
}

TEST(Excerpt, cuts_between_characters_and_replaces_what_JSON_would_not_take) {
  EXPECT_EQ(excerpt("short"), "short");
  EXPECT_EQ(excerpt("abcdef", 4), "abcd");
  EXPECT_EQ(excerpt("ab\xc3\xa9", 3), "ab");
  EXPECT_EQ(excerpt("ab\xc3\xa9", 4), "ab\xc3\xa9");
  EXPECT_EQ(excerpt("a\x01\xff\xc3z"), "a???z");
  EXPECT_EQ(excerpt(""), "");
}

TEST(RandomHex, has_two_digits_a_byte_and_never_repeats) {
  std::set<std::string> drawn;
  for (int i = 0; i < 100; ++i) drawn.insert(random_hex(16));
  EXPECT_EQ(drawn.size(), 100U);
  EXPECT_EQ(drawn.begin()->size(), 32U);
  EXPECT_EQ(drawn.begin()->find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_EQ(random_hex(0), "");
}

TEST(EqualSecrets, are_equal_only_if_every_byte_is) {
  EXPECT_TRUE(equal_secrets("token", "token"));
  EXPECT_TRUE(equal_secrets("", ""));
  EXPECT_FALSE(equal_secrets("token", "tokeN"));
  EXPECT_FALSE(equal_secrets("token", "toke"));
}

}  // namespace
}  // namespace tessera
