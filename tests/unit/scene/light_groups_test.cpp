#include "common/scene/light_groups.hpp"

#include <gmock/gmock.h>

#include "tests/unit/scene/support.hpp"

namespace tessera::scene {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* lit = R"("environment": {"radiance": 1, "group": "sky"},
  "materials": {"tube": {"type": "emitter", "radiance": 1, "group": "neon"},
                "wall": {"type": "diffuse"}},
  "lights": [{"type": "point", "name": "lamp", "position": [0, 0, 0], "intensity": 1, "group": "key"},
             {"type": "point", "name": "rim", "position": [0, 0, 0], "intensity": 1}],)";

TEST(LightGroups, are_named_by_what_emits_and_listed_behind_the_default) {
  const Scene scene = parse(scene_with(lit));
  EXPECT_EQ(scene.environment->light_group, "sky");
  EXPECT_EQ(scene.materials[0].light_group, "neon");
  EXPECT_EQ(scene.lights[0].light_group, "key");
  EXPECT_EQ(scene.lights[1].light_group, "");
  EXPECT_THAT(light_groups(scene), ElementsAre("default", "key", "neon", "sky"));
}

TEST(LightGroups, can_be_given_by_name) {
  const Scene scene = parse(scene_with(std::string(lit) + R"(
    "light_groups": {"key": ["rim", "tube"], "default": ["lamp"], "day": ["environment"]},)"));
  EXPECT_EQ(scene.environment->light_group, "day");
  EXPECT_EQ(scene.materials[0].light_group, "key");
  EXPECT_EQ(scene.lights[0].light_group, "");
  EXPECT_EQ(scene.lights[1].light_group, "key");
}

TEST(LightGroups, of_what_is_not_there_or_does_not_emit_are_refused) {
  const auto refused = [](const std::string& members) {
    return std::string(error_of(scene_with(lit + members)).what());
  };
  EXPECT_THAT(refused(R"("light_groups": {"a": ["lmap"]},)"), HasSubstr("did you mean \"lamp\"?"));
  EXPECT_THAT(refused(R"("light_groups": {"a": ["wall"]},)"),
              HasSubstr("unknown light or emitting material \"wall\""));
  EXPECT_THAT(refused(R"("light_groups": {"a.b": ["lamp"]},)"),
              HasSubstr("expected a light group's name"));
  EXPECT_THAT(
      error_of(scene_with(R"("materials": {"a": {"type": "diffuse", "group": "b"}},)")).what(),
      HasSubstr("only what emits is in a light group"));
}

TEST(LightGroups, that_a_job_asks_for_must_be_there) {
  const std::vector<std::string> groups{"default", "key"};
  EXPECT_NO_THROW(check_light_groups({"light_key", "Z"}, groups));
  EXPECT_THROW(check_light_groups({"light_kez"}, groups), Error);
}

}  // namespace
}  // namespace tessera::scene
