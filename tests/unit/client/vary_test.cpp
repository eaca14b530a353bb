#include "client/vary.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/unit/client/support.hpp"

namespace tessera::client {
namespace {

TEST(Vary, values_are_json_or_bare_words_in_their_order) {
  const Vary numbers = vary_from("samples=1,4,16,64");
  EXPECT_EQ(numbers.parameter, "samples");
  EXPECT_EQ(numbers.values, (std::vector<Json>{1, 4, 16, 64}));
  EXPECT_EQ(vary_from("x=0.5, 1e3 ,-2").values, (std::vector<Json>{0.5, 1e3, -2}));
  EXPECT_EQ(vary_from("integrator=path,cosine").values, (std::vector<Json>{"path", "cosine"}));
  EXPECT_EQ(vary_from("x=true,null,\"64\",50mm.left").values,
            (std::vector<Json>{true, nullptr, "64", "50mm.left"}));
}

TEST(Vary, commas_within_brackets_and_quotes_belong_to_the_value) {
  EXPECT_EQ(vary_from("m.white.reflectance=[.2,.2,.2],[0.8,.8,-.8]").values,
            (std::vector<Json>{{0.2, 0.2, 0.2}, {0.8, 0.8, -0.8}}));
  EXPECT_EQ(vary_from(R"(a.b="x,.5]","\",",{"k": [1, {"l": ",}"}]})").values,
            (std::vector<Json>{"x,.5]", "\",", {{"k", {1, {{"l", ",}"}}}}}}));
}

TEST(Vary, the_first_equals_sign_parts_name_and_values) {
  const Vary vary = vary_from("shapes[3].file=a=b.obj");
  EXPECT_EQ(vary.parameter, "shapes[3].file");
  EXPECT_EQ(vary.values, (std::vector<Json>{"a=b.obj"}));
}

TEST(Vary, what_cannot_be_read_is_refused_and_named) {
  struct Wrong {
    const char* text;
    const char* key;
    const char* part;
  };
  for (const Wrong& wrong :
       std::vector<Wrong>{{"samples", "--vary", "NAME=VALUE"},
                          {"=1,2", "--vary", "NAME=VALUE"},
                          {"", "--vary", "NAME=VALUE"},
                          {"samples=", "--vary samples", "one comma"},
                          {"samples=1,,2", "--vary samples", "one comma"},
                          {"samples=1,2,", "--vary samples", "one comma"},
                          {"samples=4,1,4", "--vary samples", "the value 4 stands twice"},
                          {"a.b=[1,2", "--vary a.b", "expected a JSON value"},
                          {"a.b=[x,y]", "--vary a.b", "expected a JSON value"},
                          {"a.b={\"k\":1,\"k\":2}", "--vary a.b", "expected a JSON value"},
                          {"a.b=\"open", "--vary a.b", "expected a JSON value"},
                          {"a.b=\xff", "--vary a.b", "UTF-8"}}) {
    const Error error = error_of([&] { (void)vary_from(wrong.text); });
    EXPECT_EQ(error.kind(), ErrorKind::bad_input) << wrong.text;
    EXPECT_EQ(error.place().key, wrong.key) << wrong.text;
    EXPECT_NE(error.message().find(wrong.part), std::string::npos) << error.message();
  }
}

TEST(Vary, a_value_is_shown_as_people_write_it) {
  EXPECT_EQ(value_text(Json("path")), "path");
  EXPECT_EQ(value_text(Json(0.25)), "0.25");
  EXPECT_EQ(value_text(Json({0.2, 0.2, 1})), "[0.2,0.2,1]");
}

}  // namespace
}  // namespace tessera::client
