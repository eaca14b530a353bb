#include "common/base/json.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"

namespace tessera {
namespace {

using testing::HasSubstr;

/// The error that a call throws; a test fails if it throws none.
template <class Call>
Error error_of(Call call) {
  try {
    call();
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was thrown";
  return Error(ErrorKind::failed, "");
}

Error parse_error(const std::string& text) {
  const Error error = error_of([&] { parse_json(text, "a.json"); });
  EXPECT_EQ(error.kind(), ErrorKind::bad_input);
  EXPECT_EQ(error.place().file, "a.json");
  // Whatever was in the text, its error can be said in JSON.
  EXPECT_NO_THROW(static_cast<void>(Json(error.what()).dump())) << error.what();
  return error;
}

TEST(ParseJson, gives_what_stands_there) {
  const Json json = parse_json(R"( {"a": [1, -2.5, "x", true, null], "b": {}} )", "a.json");
  EXPECT_EQ(json["a"][1], -2.5);
  EXPECT_EQ(json["a"].size(), 5U);
  EXPECT_TRUE(json["b"].is_object());
}

TEST(ParseJson, refuses_a_doubled_key_where_it_stands_a_second_time) {
  const Error error = parse_error("{\"a\": 1,\n \"b\": {\"a\": 2},\n  \"a\": 3}");
  EXPECT_EQ(error.message(), "the key \"a\" stands twice in one object");
  EXPECT_EQ(error.place().line, 3);
  EXPECT_GE(error.place().column, 3);
  EXPECT_LE(error.place().column, 5);
}

TEST(ParseJson, takes_the_same_key_in_different_objects) {
  EXPECT_EQ(parse_json(R"([{"a": 1}, {"a": {"a": 2}}])", "a.json").size(), 2U);
}

TEST(ParseJson, refuses_200000_nested_brackets_at_the_first_that_is_too_deep) {
  for (const std::string& bracket : {std::string("["), std::string("{\"a\":")}) {
    std::string text;
    for (int i = 0; i < 200'000; ++i) text += bracket;
    const Error error = parse_error(text);
    EXPECT_EQ(error.message(), "nested deeper than 64 levels");
    EXPECT_EQ(error.place().line, 1);
    EXPECT_LE(error.place().column, static_cast<int>(65 * bracket.size()));
  }
  const std::string deepest =
      std::string(limits::json_depth, '[') + std::string(limits::json_depth, ']');
  EXPECT_NO_THROW(parse_json(deepest, "a.json"));
}

TEST(ParseJson, tells_where_the_grammar_is_broken) {
  const Error error = parse_error("{\n  \"a\": 1,\n  \"b\": tru\n}");
  EXPECT_EQ(error.place().line, 3);
  EXPECT_THAT(error.message(), HasSubstr("not valid JSON"));
  EXPECT_EQ(parse_error("{\"a\": 1} x").place().column, 10);
  for (const char* text :
       {"", " ", "{", "[1,]", "{\"a\" 1}", "nul", "01", "1e999", "\"\\x\"", "// no comments\n1"})
    parse_error(text);
}

TEST(ParseJson, refuses_what_is_not_UTF8_with_a_message_that_is) {
  parse_error("\"\xff\"");
  parse_error("{\"\xc3\x28\": 1}");
  parse_error("\xfe\xff");
  std::string key;
  for (int i = 0; i < 40; ++i) key += "\xe5\xa4\x9c";  // three bytes each: 64 would cut one in two
  parse_error("{\"" + key + "\": 1, \"" + key + "\": 2}");
}

TEST(ObjectReader, reads_members_by_name_and_takes_the_fallback_for_lacking_ones) {
  const Json json =
      parse_json(R"({"name": "x", "count": 3, "ratio": 0.5, "whole": 2, "on": true})", "a.json");
  ObjectReader in(json, "film");
  EXPECT_EQ(in.text("name"), "x");
  EXPECT_EQ(in.text_or("other", "y"), "y");
  EXPECT_EQ(in.integer("count", 1, 3), 3);
  EXPECT_EQ(in.integer_or("lacking", 1, 3, 2), 2);
  EXPECT_EQ(in.number("ratio", 0, 1), 0.5);
  EXPECT_EQ(in.number("whole", 0, 4), 2.0);
  EXPECT_EQ(in.number_or("none", 0, 1, 0.25), 0.25);
  EXPECT_TRUE(in.boolean_or("on", false));
  EXPECT_TRUE(in.boolean_or("off", true));
  EXPECT_TRUE(in.has("count"));
  EXPECT_NO_THROW(in.finish());
}

std::string message_of(const char* text, void (*read)(ObjectReader&)) {
  const Json json = parse_json(text, "a.json");
  return error_of([&] {
           ObjectReader in(json, "film");
           read(in);
           in.finish();
         })
      .what();
}

TEST(ObjectReader, says_the_keys_path_what_was_expected_and_what_was_found) {
  EXPECT_EQ(message_of("{}", [](ObjectReader& in) { in.text("name"); }),
            "film.name: is required, and is not there");
  EXPECT_EQ(message_of(R"({"name": 3})", [](ObjectReader& in) { in.text("name"); }),
            "film.name: expected a string, found number");
  EXPECT_EQ(message_of(R"({"name": null})", [](ObjectReader& in) { in.text_or("name", "x"); }),
            "film.name: expected a string, found null");
  EXPECT_EQ(message_of(R"({"on": 1})", [](ObjectReader& in) { in.boolean_or("on", false); }),
            "film.on: expected true or false, found number");
  const auto width = [](ObjectReader& in) { in.integer("width", 1, 100); };
  EXPECT_EQ(message_of(R"({"width": 0})", width),
            "film.width: expected a whole number from 1 to 100, found 0");
  EXPECT_EQ(message_of(R"({"width": 101})", width),
            "film.width: expected a whole number from 1 to 100, found 101");
  EXPECT_EQ(message_of(R"({"width": -1})", width),
            "film.width: expected a whole number from 1 to 100, found -1");
  EXPECT_EQ(message_of(R"({"width": 1.5})", width),
            "film.width: expected a whole number from 1 to 100, found 1.5");
  EXPECT_EQ(message_of(R"({"width": "9"})", width),
            "film.width: expected a whole number from 1 to 100, found \"9\"");
  EXPECT_EQ(message_of(R"({"width": [1, 2]})", width),
            "film.width: expected a whole number from 1 to 100, found array");
  EXPECT_EQ(message_of(R"({"width": 18446744073709551615})", width),
            "film.width: expected a whole number from 1 to 100, found 18446744073709551615");
  EXPECT_EQ(message_of(R"({"ratio": 2})", [](ObjectReader& in) { in.number("ratio", 0, 1); }),
            "film.ratio: expected a number from 0 to 1, found 2");
  EXPECT_EQ(
      message_of(R"({"ratio": "1"})", [](ObjectReader& in) { in.number_or("ratio", 0, 1, 0); }),
      "film.ratio: expected a number, found string");
}

TEST(ObjectReader, takes_no_key_that_nobody_asked_for_and_names_the_nearest) {
  const auto read = [](ObjectReader& in) {
    in.integer_or("width", 1, 100, 1);
    in.integer_or("height", 1, 100, 1);
  };
  EXPECT_EQ(message_of(R"({"width": 3, "heigth": 4})", read),
            "film.heigth: unknown key \"heigth\"; did you mean \"height\"? (expected one of: "
            "width, height)");
}

TEST(ObjectReader, takes_objects_alone) {
  const Json json = parse_json("[1]", "a.json");
  EXPECT_STREQ(error_of([&] { ObjectReader in(json, "film"); }).what(),
               "film: expected an object, found array");
}

TEST(ObjectReader, at_the_root_has_keys_without_a_prefix) {
  const Json json = parse_json("{}", "a.json");
  ObjectReader in(json, "");
  EXPECT_EQ(in.path_of("name"), "name");
  EXPECT_STREQ(error_of([&] { in.fail("name", "is odd"); }).what(), "name: is odd");
}

}  // namespace
}  // namespace tessera
