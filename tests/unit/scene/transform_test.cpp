#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/scene/support.hpp"

namespace tessera::scene {
namespace {

Transform transform_of(const std::string& steps) {
  const Scene scene = parse(scene_with(R"("materials": {"m": {"type": "diffuse"}},
    "shapes": [{"type": "sphere", "material": "m", "transform": )" +
                                       steps + "}],"));
  return scene.shapes.at(0).to_world;
}

Vec3 moved(const Transform& t, const Vec3& p) {
  Vec3 out{};
  for (std::size_t row = 0; row < 3; ++row)
    out[row] =
        t.m[row * 4] * p[0] + t.m[row * 4 + 1] * p[1] + t.m[row * 4 + 2] * p[2] + t.m[row * 4 + 3];
  return out;
}

void expect_near(const Vec3& a, const Vec3& b) {
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 1e-12) << i;
}

TEST(Transform, the_first_step_is_applied_first) {
  const Transform t = transform_of(R"([{"scale": 2}, {"translate": [1, 0, 0]}])");
  expect_near(moved(t, {1, 1, 1}), {3, 2, 2});
  const Transform u = transform_of(R"([{"translate": [1, 0, 0]}, {"scale": 2}])");
  expect_near(moved(u, {1, 1, 1}), {4, 2, 2});
}

TEST(Transform, quarter_turns_are_exact_and_counter_clockwise) {
  EXPECT_EQ(moved(transform_of(R"([{"rotate": {"axis": [0, 0, 2], "degrees": 90}}])"), {1, 0, 0}),
            (Vec3{0, 1, 0}));
  EXPECT_EQ(moved(transform_of(R"([{"rotate": {"axis": [1, 0, 0], "degrees": 450}}])"), {0, 1, 0}),
            (Vec3{0, 0, 1}));
  EXPECT_EQ(moved(transform_of(R"([{"rotate": {"axis": [0, 1, 0], "degrees": -90}}])"), {1, 0, 0}),
            (Vec3{0, 0, 1}));
  EXPECT_EQ(moved(transform_of(R"([{"rotate": {"axis": [0, 1, 0], "degrees": 180}}])"), {1, 0, 0}),
            (Vec3{-1, 0, 0}));
}

TEST(Transform, turns_about_a_slanted_axis_keep_it_and_lengths) {
  const Transform t = transform_of(R"([{"rotate": {"axis": [1, 1, 1], "degrees": 120}}])");
  expect_near(moved(t, {1, 0, 0}), {0, 1, 0});
  expect_near(moved(t, {2, 2, 2}), {2, 2, 2});
}

TEST(Transform, matrices_have_12_or_16_numbers_in_rows) {
  const Transform expected{{1, 2, 3, 4, 0, 1, 5, 6, 0, 0, 1, 7}};
  EXPECT_EQ(transform_of(R"([{"matrix": [1,2,3,4, 0,1,5,6, 0,0,1,7]}])"), expected);
  EXPECT_EQ(transform_of(R"([{"matrix": [1,2,3,4, 0,1,5,6, 0,0,1,7, 0,0,0,1]}])"), expected);
}

TEST(Transform, an_empty_list_changes_nothing) { EXPECT_EQ(transform_of("[]"), Transform{}); }

TEST(Transform, small_scales_and_mirrors_are_fine) {
  EXPECT_NO_THROW(transform_of(R"([{"scale": 1e-6}])"));
  EXPECT_NO_THROW(transform_of(R"([{"scale": [1, 1, -1]}])"));
}

TEST(Transform, the_product_applies_its_right_side_first) {
  const Transform a{{0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3}}, b{{2, 0, 0, 5, 0, 3, 0, 6, 0, 0, 4, 7}};
  expect_near(moved(a * b, {1, 2, 3}), moved(a, moved(b, {1, 2, 3})));
}

}  // namespace
}  // namespace tessera::scene
