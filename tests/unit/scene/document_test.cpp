#include "common/scene/document.hpp"

#include <gtest/gtest.h>

#include <string>

#include "common/base/limits.hpp"

namespace tessera::scene {
namespace {

Error refusal(const std::string& text) {
  try {
    const Document document(text, "a.json");
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "accepted: " << text.substr(0, 100);
  return Error(ErrorKind::failed, "none");
}

void expect_place(const Place& place, int line, int column, const std::string& key) {
  EXPECT_EQ(place.file, "a.json");
  EXPECT_EQ(place.line, line);
  EXPECT_EQ(place.column, column);
  EXPECT_EQ(place.key, key);
}

TEST(Document, knows_the_line_column_and_path_of_every_key_and_value) {
  const Document document(
      "{\n  \"a\": [1, -2.5e1,\n   true , \"x\\\"y\"],\n  \"b\": {\"c\" : {}, \"d\":null}}\n",
      "a.json");
  // Nodes in order: root, "a", list, 1, -25, true, "x\"y", "b", object, "c", {}, "d", null.
  expect_place(document.place(0), 1, 1, "");
  expect_place(document.place(1), 2, 3, "a");
  expect_place(document.place(2), 2, 8, "a");
  expect_place(document.place(3), 2, 9, "a[0]");
  expect_place(document.place(4), 2, 12, "a[1]");
  expect_place(document.place(5), 3, 4, "a[2]");
  expect_place(document.place(6), 3, 11, "a[3]");
  expect_place(document.place(7), 4, 3, "b");
  expect_place(document.place(8), 4, 8, "b");
  expect_place(document.place(9), 4, 9, "b.c");
  expect_place(document.place(10), 4, 15, "b.c");
  expect_place(document.place(11), 4, 19, "b.d");
  expect_place(document.place(12), 4, 23, "b.d");
  EXPECT_EQ(document.string(document.node(6)), "x\"y");
  EXPECT_EQ(document.node(4).kind, Kind::number);
  EXPECT_EQ(document.node(4).number, -25);
  EXPECT_EQ(document.node(2).count, 4U);
  EXPECT_EQ(document.node(0).count, 2U);
  EXPECT_EQ(document.node(8).end, 13U);
}

TEST(Document, counts_columns_behind_a_byte_order_mark_and_escapes) {
  const Document document("\xEF\xBB\xBF{\"\\u00e9\\\\\": 1}", "a.json");
  EXPECT_EQ(document.place(0).column, 4);  // in bytes
  EXPECT_EQ(document.place(2).column, 17);
  EXPECT_EQ(document.string(document.node(1)), "\xC3\xA9\\");
}

TEST(Document, refuses_a_doubled_key_where_it_stands_the_second_time) {
  const Error error = refusal("{\"a\": 1,\n \"b\": {\"x\": 1, \"y\": 2,\n  \"x\": 3}}");
  EXPECT_EQ(error.kind(), ErrorKind::bad_input);
  EXPECT_EQ(error.place().line, 3);
  EXPECT_EQ(error.place().column, 3);
  EXPECT_EQ(error.message(), "the key \"x\" stands twice in one object, first at line 2, column 8");
}

TEST(Document, takes_one_key_in_two_objects) {
  EXPECT_NO_THROW(Document("[{\"a\": 1}, {\"a\": {\"a\": 2}}]", "a.json"));
}

TEST(Document, refuses_two_hundred_thousand_nested_brackets_at_the_limit) {
  for (const char* bracket : {"[", "{\"a\":"}) {
    std::string text;
    for (int i = 0; i < 200'000; ++i) text += bracket;
    const Error error = refusal(text);
    EXPECT_EQ(error.message(), "nested deeper than 64 levels");
    EXPECT_EQ(error.place().line, 1);
    EXPECT_EQ(error.place().column,
              static_cast<int>(std::string(bracket).size()) * limits::json_depth + 1);
  }
}

TEST(Document, takes_nesting_at_the_limit) {
  const auto depth = static_cast<std::size_t>(limits::json_depth);
  EXPECT_NO_THROW(Document(std::string(depth, '[') + std::string(depth, ']'), "a.json"));
}

TEST(Document, refuses_numbers_that_no_double_holds) {
  const Error error = refusal("{\"a\":\n  [1,  1e400]}");
  EXPECT_EQ(error.message(), "a number beyond the range of double precision");
  EXPECT_EQ(error.place().line, 2);
  EXPECT_EQ(error.place().column, 8);
}

TEST(Document, refuses_what_is_no_json_with_its_place) {
  for (const char* text :
       {"", "{", "[1,]", "{\"a\" 1}", "[NaN]", "[Infinity]", "[01]", "{\"a\": 1} x", "\"\\x\"",
        "[1] // no", "\"\xff\"", "{'a': 1}", "[-]", "tru"}) {
    const Error error = refusal(text);
    EXPECT_EQ(error.kind(), ErrorKind::bad_input) << text;
    EXPECT_EQ(error.place().line, 1) << text;
    EXPECT_GE(error.place().column, 1) << text;
    EXPECT_NE(error.message().find("not valid JSON"), std::string::npos) << text;
  }
  EXPECT_EQ(refusal("{\n\"a\": nope}").place().line, 2);
}

TEST(Document, reads_integers_up_to_64_bits_exactly) {
  const Document document("[9223372036854775807, -9223372036854775808, 18446744073709551615]",
                          "a.json");
  EXPECT_EQ(document.node(1).integer, INT64_MAX);
  EXPECT_EQ(document.node(2).integer, INT64_MIN);
  EXPECT_EQ(document.node(3).kind, Kind::number);
}

}  // namespace
}  // namespace tessera::scene
