#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/scene/support.hpp"

namespace tessera::scene {
namespace {

using testing::HasSubstr;

std::string with_light(const std::string& members) {
  return scene_with("\"lights\": [{" + members + "}],");
}

TEST(Lights, of_every_type_are_read) {
  const Scene scene = parse(scene_with(R"("lights": [
    {"type": "point", "position": [1, 2, 3], "intensity": 4},
    {"type": "spot", "name": "stage", "position": [0, 5, 0], "direction": [0, -2, 0], "intensity": [1, 2, 3],
     "inner_angle": 10, "outer_angle": 20},
    {"type": "directional", "direction": [1, -1, 0], "irradiance": 7, "angle": 0.53}],)"));
  ASSERT_EQ(scene.lights.size(), 3U);
  EXPECT_EQ(scene.lights[0].name, "point 0");
  EXPECT_EQ(std::get<PointLight>(scene.lights[0].shape).position, (Vec3{1, 2, 3}));
  EXPECT_EQ(std::get<PointLight>(scene.lights[0].shape).intensity, (Color{4, 4, 4}));
  EXPECT_EQ(scene.lights[1].name, "stage");
  const auto& spot = std::get<SpotLight>(scene.lights[1].shape);
  EXPECT_EQ(spot.direction, (Vec3{0, -2, 0}));
  EXPECT_EQ(spot.inner_degrees, 10);
  EXPECT_EQ(spot.outer_degrees, 20);
  const auto& sun = std::get<DirectionalLight>(scene.lights[2].shape);
  EXPECT_EQ(sun.irradiance, (Color{7, 7, 7}));
  EXPECT_EQ(sun.angle_degrees, 0.53);
}

TEST(Lights, that_cannot_shine_are_refused_where_they_stand) {
  const struct {
    const char *members, *key, *message;
  } cases[] = {
      {R"("type": "pont", "position": [0, 0, 0])", "lights[0].type", "did you mean \"point\"?"},
      {R"("type": "point", "intensity": 1)", "lights[0].position", "is required"},
      {R"("type": "point", "position": [0, 0, 0], "intensity": -1)", "lights[0].intensity",
       "from 0"},
      {R"("type": "directional", "direction": [0, 0, 0], "irradiance": 1)", "lights[0].direction",
       "needs a length"},
      {R"("type": "directional", "direction": [0, 1, 0], "irradiance": 1, "angle": 181)",
       "lights[0].angle", "to 180"},
      {R"("type": "spot", "position": [0, 0, 0], "direction": [0, 1, 0], "intensity": 1, "inner_angle": 45)",
       "lights[0].inner_angle", "not below the outer"},
      {R"("type": "point", "position": [0, 0, 0], "intensity": 1, "radius": 2)", "lights[0].radius",
       "unknown key"}};
  for (const auto& one : cases) {
    const Error error = error_of(with_light(one.members));
    EXPECT_EQ(error.place().key, one.key);
    EXPECT_THAT(error.message(), HasSubstr(one.message));
  }
}

}  // namespace
}  // namespace tessera::scene
