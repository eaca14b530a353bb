#include "client/scene_path.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/unit/client/support.hpp"

namespace tessera::client {
namespace {

Json scene() {
  return Json::parse(R"({
    "camera": {"eye": [0, 1, 5], "target": [0, 0, 0], "fov": 40},
    "materials": {"white": {"reflectance": 0.5}, "white.warm": {"reflectance": [0.9, 0.8, 0.7]}, "a[1]": {"ior": 1.5}},
    "shapes": [{"type": "sphere"}, {"type": "box", "low": [1, 2, 3]}]})");
}

TEST(ScenePath, leads_through_keys_and_items) {
  Json json = scene();
  EXPECT_EQ(value_at(json, "camera.fov"), 40);
  EXPECT_EQ(value_at(json, "camera"), scene()["camera"]);
  EXPECT_EQ(value_at(json, "shapes[1].low[2]"), 3);
  EXPECT_EQ(value_at(json, "shapes[0]"), scene()["shapes"][0]);
  value_at(json, "materials.white.reflectance") = {0.1, 0.2, 0.3};
  EXPECT_EQ(json["materials"]["white"]["reflectance"], (Json{0.1, 0.2, 0.3}));
}

TEST(ScenePath, a_name_with_a_dot_or_a_bracket_in_it_is_found_and_the_longest_wins) {
  Json json = scene();
  EXPECT_EQ(value_at(json, "materials.white.warm.reflectance[0]"), 0.9);
  EXPECT_EQ(value_at(json, "materials.white.warm"), scene()["materials"]["white.warm"]);
  EXPECT_EQ(value_at(json, "materials.a[1].ior"), 1.5);
}

TEST(ScenePath, what_is_not_there_is_an_error_that_names_the_nearest) {
  struct Wrong {
    const char* path;
    const char* message;
  };
  for (const Wrong& wrong : std::vector<Wrong>{
           {"camera.fv",
            "unknown key of camera \"fv\"; did you mean \"fov\"? (expected one of: "
            "eye, fov, target)"},
           {"camra.fov", "unknown key of the scene \"camra\"; did you mean \"camera\"?"},
           {"materials.wite.reflectance", "did you mean \"white\"?"},
           {"materials.white.albedo", "unknown key of materials.white \"albedo\""},
           {"camera.fov.x", "camera.fov is a number and has no keys"},
           {"camera[0]", "camera is an object and has no items"},
           {"shapes.low", "shapes is a list and has no keys"},
           {"shapes[2]", "shapes has 2 items, the first is [0]"},
           {"shapes[-1]", "expected an index such as [0] behind shapes"},
           {"shapes[]", "expected an index"},
           {"shapes[1", "expected an index"},
           {"shapes[0]type", "expected a dot or an index behind shapes[0]"},
           {"camera.", "unknown key of camera"},
           {".camera", "unknown key of the scene"}}) {
    Json json = scene();
    const Error error = error_of([&] { (void)value_at(json, wrong.path); });
    EXPECT_EQ(error.kind(), ErrorKind::bad_input) << wrong.path;
    EXPECT_EQ(error.place().key, wrong.path);
    EXPECT_NE(error.message().find(wrong.message), std::string::npos)
        << wrong.path << ": " << error.message();
    EXPECT_EQ(json, scene()) << wrong.path;
  }
}

}  // namespace
}  // namespace tessera::client
