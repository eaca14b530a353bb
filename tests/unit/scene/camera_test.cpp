#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/unit/scene/support.hpp"

namespace tessera::scene {
namespace {

using ::testing::HasSubstr;

std::string scene_of(const std::string& members) {
  return R"({"tessera": 1, "camera": {"eye": [0, 0, 5], "target": [0, 0, 1], )" + members + "}}";
}
Camera camera_of(const std::string& members) { return parse(scene_of(members)).cameras.at(0); }

TEST(Cameras, OrthographicHeightTakesThePlaceOfAFieldOfView) {
  const Camera camera = camera_of("\"orthographic_height\": 2.5");
  EXPECT_EQ(camera.orthographic_height, 2.5);
  EXPECT_EQ(camera.projection, Projection::orthographic);
}

TEST(Cameras, LensIsTakenWithItsFocusOnTheTarget) {
  const Camera camera = camera_of(
      R"("aperture_radius": 0.25, "aperture_blades": 6, "aperture_rotation": 15, "shift": [0.5, -1])");
  EXPECT_EQ(camera.projection, Projection::perspective);
  EXPECT_EQ(camera.lens.radius, 0.25);
  EXPECT_EQ(camera.lens.focus_distance, 4);
  EXPECT_EQ(camera.lens.blades, 6);
  EXPECT_EQ(camera.lens.rotation_degrees, 15);
  EXPECT_EQ(camera.shift, (Vec2{0.5, -1}));
  EXPECT_EQ(camera_of("\"focus_distance\": 9").lens.focus_distance, 9);
}

TEST(Cameras, FNumberIsOfALensInMillimetresInAWorldOfMetres) {
  const Camera camera = camera_of(R"("focal_length": 50, "film_size": [36, 24], "f_number": 2)");
  EXPECT_DOUBLE_EQ(camera.lens.radius, 0.0125);
}

TEST(Cameras, EquirectangularNeedsNothingMore) {
  EXPECT_EQ(camera_of(R"("projection": "equirectangular")").projection,
            Projection::equirectangular);
}

TEST(Cameras, WhatOneKindLacksIsSaidAtItsPlace) {
  const struct {
    const char* members;
    const char* key;
    const char* message;
  } cases[] = {
      {R"("orthographic_height": 2.5, "fov": 40)", "camera.fov", "only perspective cameras"},
      {R"("orthographic_height": 0)", "camera.orthographic_height", "expected"},
      {R"("projection": "orthographic")", "camera.orthographic_height", "required"},
      {R"("projection": "perspective", "orthographic_height": 1)", "camera.orthographic_height",
       "only orthographic cameras"},
      {R"("projection": "equirectangular", "aperture_radius": 1)", "camera.aperture_radius",
       "only perspective and orthographic cameras"},
      {R"("projection": "equirectangular", "shift": [1, 0])", "camera.shift",
       "only perspective and orthographic cameras"},
      {R"("projection": "equirectangula")", "camera.projection", "equirectangular"},
      {R"("f_number": 2)", "camera.f_number", "needs the focal_length"},
      {R"("f_number": 2, "aperture_radius": 1, "focal_length": 50, "film_size": [36, 24])",
       "camera.aperture_radius", "not both"},
      {R"("aperture_blades": 2)", "camera.aperture_blades", "3"},
      {R"("focus_distance": 0)", "camera.focus_distance", "expected"}};
  for (const auto& one : cases) {
    const Error error = error_of(scene_of(one.members));
    EXPECT_EQ(error.place().key, one.key) << one.members;
    EXPECT_THAT(error.message(), HasSubstr(one.message)) << one.members;
  }
}

}  // namespace
}  // namespace tessera::scene
