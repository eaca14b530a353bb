#include "worker/scene/visibility.hpp"

#include <gtest/gtest.h>

#include "worker/scene/build.hpp"

namespace tessera::worker {
namespace {

using scene::Visibility;

scene::Transform moved(double x) { return {{1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0}}; }

scene::Shape square(std::uint32_t material, double x, const Visibility& visibility) {
  return {"square", scene::Quad{{-0.5, -0.5, 0}}, material, moved(x), visibility};
}

/// Material 0 is diffuse, 1 emits.
scene::Scene scene_of(std::vector<scene::Shape> shapes) {
  scene::Scene scene;
  scene.cameras.emplace_back();
  scene.materials = {{"a", scene::Diffuse{}}, {"glow", scene::Emitter{}}};
  scene.shapes = std::move(shapes);
  return scene;
}

render::Scene built(scene::Scene scene) { return build_scene(std::move(scene), accel::Device()); }

/// What meets the square at `x`: one letter each.
std::string seen_at(const render::Scene& scene, float x) {
  render::Ray ray;
  ray.origin = {x, 0, 5};
  ray.direction = {0, 0, -1};
  std::string out;
  if (scene.intersect(ray, render::ray_mask::camera).any()) out += 'c';
  if (scene.occluded(ray)) out += 's';
  if (scene.intersect(ray, render::ray_mask::indirect).any()) out += 'i';
  return out;
}

TEST(VisibilityOfAScene, ShapesOfUnlikeVisibilityAreNotMerged) {
  const render::Scene scene =
      built(scene_of({square(0, 0, {}), square(0, 2, {.camera = false}), square(0, 4, {}),
                      square(0, 6, {.shadow = false}), square(0, 8, {.indirect = false})}));
  EXPECT_EQ(scene.groups.at(0).geometries.size(), 4U);
  EXPECT_EQ(seen_at(scene, 0), "csi");
  EXPECT_EQ(seen_at(scene, 2), "si");
  EXPECT_EQ(seen_at(scene, 4), "csi");
  EXPECT_EQ(seen_at(scene, 6), "ci");
  EXPECT_EQ(seen_at(scene, 8), "cs");
}

TEST(VisibilityOfAScene, AnInstanceHidesWhatItsShapesDoNot) {
  scene::Scene placed = scene_of({});
  placed.objects = {{"once", {square(0, 0, {.shadow = false})}},
                    {"often", {square(0, 0, {.shadow = false})}}};
  placed.instances = {{0, moved(0), {.camera = false}},
                      {1, moved(2), {.camera = false}},
                      {1, moved(4), {}},
                      {1, moved(6), {.indirect = false, .holdout = true}}};
  const render::Scene scene = built(std::move(placed));
  EXPECT_EQ(seen_at(scene, 0), "i");
  EXPECT_EQ(seen_at(scene, 2), "i");
  EXPECT_EQ(seen_at(scene, 4), "ci");
  EXPECT_EQ(seen_at(scene, 6), "c");
  EXPECT_EQ(scene.visibility_of(3, 0),
            (Visibility{.shadow = false, .indirect = false, .holdout = true}));
  EXPECT_TRUE(scene.has_holes);
  EXPECT_FALSE(scene.has_catchers);
}

TEST(VisibilityOfAScene, AShadowCatcherIsAHoleWhereverItIsPlaced) {
  const auto catches = [](scene::Scene scene) {
    const render::Scene made = built(std::move(scene));
    EXPECT_EQ(made.has_holes, made.has_catchers);
    return made.has_catchers;
  };
  EXPECT_FALSE(catches(scene_of({square(0, 0, {})})));
  EXPECT_TRUE(catches(scene_of({square(0, 0, {}), square(0, 2, {.shadow_catcher = true})})));
  scene::Scene placed = scene_of({});
  placed.objects = {{"often", {square(0, 0, {})}}};
  placed.instances = {{0, moved(0), {}}, {0, moved(2), {}}};
  EXPECT_FALSE(catches(placed));
  placed.instances[1].visibility.shadow_catcher = true;
  EXPECT_TRUE(catches(placed));
  const render::Scene scene = built(std::move(placed));
  EXPECT_EQ(seen_at(scene, 2), "csi");
}

TEST(VisibilityOfAScene, AnEllipsoidKeepsItsOwn) {
  scene::Shape bent{"ball", scene::Sphere{}, 0, {{1, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1, 0}}};
  bent.visibility.indirect = false;
  EXPECT_EQ(seen_at(built(scene_of({bent})), 0), "cs");
  scene::Scene placed = scene_of({});
  placed.objects = {{"often", {bent}}};
  placed.instances = {{0, moved(0), {.camera = false}}, {0, moved(5), {}}};
  const render::Scene scene = built(std::move(placed));
  EXPECT_EQ(seen_at(scene, 0), "s");
  EXPECT_EQ(seen_at(scene, 5), "cs");
}

TEST(VisibilityOfAScene, ItIsLitApartWhereScatteredRaysDoNotMeetWhatShadowRaysDo) {
  const auto apart = [](std::uint32_t material, const Visibility& visibility) {
    const render::Scene scene = built(scene_of({square(material, 0, visibility)}));
    EXPECT_FALSE(scene.has_holes);
    return scene.lit_apart;
  };
  for (const std::uint32_t material : {0U, 1U}) {
    EXPECT_FALSE(apart(material, {}));
    EXPECT_FALSE(apart(material, {.camera = false}));
    EXPECT_TRUE(apart(material, {.shadow = false}));
    EXPECT_TRUE(apart(material, {.indirect = false}));
  }
  EXPECT_FALSE(apart(0, {.shadow = false, .indirect = false}));
  EXPECT_TRUE(apart(1, {.shadow = false, .indirect = false}));
}

}  // namespace
}  // namespace tessera::worker
