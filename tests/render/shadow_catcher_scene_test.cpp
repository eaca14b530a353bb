#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "tests/render/shadow_catchers.hpp"

/// What shadow catchers are to all else in a scene, and to the tasks that take them.
namespace tessera::render::proof {
namespace {

using namespace catchers;
using scene::Visibility;

TEST(ShadowCatcher, IsAHoldoutInAllElse) {
  SceneMaker maker = ball_over_ground();
  maker.environment(1);
  const image::TileImage image = taken(maker);
  maker.description.shapes.front().visibility = {.holdout = true};
  const image::TileImage held = taken(maker);
  std::size_t covered = 0;
  for (std::size_t c = 0; c < image.channels(); ++c)
    for (std::size_t i = 0; i < image.pixels(); ++i) {
      const bool of_catchers = c >= first_of(image) && c < first_of(image) + caught_channel_count;
      ASSERT_EQ(held.plane(c)[i], of_catchers ? 0 : image.plane(c)[i]) << c << ' ' << i;
    }
  for (std::size_t i = 0; i < image.pixels(); ++i)
    covered += caught(image, caught_coverage, i) > 0 ? 1 : 0;
  EXPECT_GT(covered, image.pixels() / 2);
}

TEST(ShadowCatcher, CatchesNoShadowOfItsOwnNorOfAnother) {
  SceneMaker maker = ball_over_ground();
  maker.description.shapes[1].visibility = catching;
  maker.environment(1);
  maker.add(maker.emitter(8), scene::Quad{{1, 5, -1}, {2, 0, 0}, {0, 0, 2}});
  maker.description.shapes.back().visibility.shadow = false;
  const image::TileImage image = taken(maker);
  std::size_t hidden = 0;
  float most = 0;
  for (std::size_t i = 0; i < image.pixels(); ++i)
    most = std::max(most, caught(image, unshadowed_R, i));
  for (std::size_t i = 0; i < image.pixels(); ++i) {
    ASSERT_EQ(caught(image, caught_coverage, i), 1);
    ASSERT_EQ(image.plane(image::A)[i], 0);
    ASSERT_EQ(alpha(image, i), 0) << i;
    if (caught(image, unshadowed_R, i) < 0.6F * most) ++hidden;
  }
  EXPECT_GT(hidden, 10U) << "they stand in each other's light all the same";
}

/// Alpha of one pixel that looks down at a catcher under a sun, through what `add` puts there.
double alpha_under(const std::function<void(SceneMaker&)>& add) {
  SceneMaker maker;
  maker.add(maker.diffuse(0.5), ground());
  maker.description.shapes.back().visibility = catching;
  maker.description.lights.push_back({"s", scene::DirectionalLight{{1, -1, 0}, {2, 2, 2}, 0}});
  maker.look({0, 10, 0.1}, {0, 0, 0}, 0.01, {0, 0, -1});
  maker.description.film_transparent = true;
  add(maker);
  TaskRequest request = request_for(64);
  request.settings.width = request.settings.height = 1;
  request.window = {0, 0, 1, 1};
  return alpha(taken(maker.build(), request), 0);
}

/// A plate in the sun's way, and not in the camera's.
void add_plate(SceneMaker& maker, std::uint32_t material, const Visibility& visibility = {}) {
  maker.add(material, scene::Quad{{-5, 2, 3}, {4, 0, 0}, {0, 0, -6}});
  maker.description.shapes.back().visibility = visibility;
}
/// What is there only by this part.
std::uint32_t veil(SceneMaker& maker, double share) {
  const std::uint32_t material = maker.diffuse(0.5);
  maker.description.materials.back().opacity = {.mode = scene::Opacity::Mode::blend,
                                                .alpha = {.factor = share}};
  return material;
}

TEST(ShadowCatcher, CatchesTheShadowsOfWhatShadows) {
  EXPECT_EQ(alpha_under([](SceneMaker&) {}), 0);
  EXPECT_EQ(alpha_under([](SceneMaker& maker) { add_plate(maker, maker.diffuse(0.5)); }), 1);
  EXPECT_EQ(alpha_under([](SceneMaker& maker) {
              add_plate(maker, maker.diffuse(0.5), {.camera = false, .indirect = false});
            }),
            1);
  EXPECT_EQ(alpha_under(
                [](SceneMaker& maker) { add_plate(maker, maker.diffuse(0.5), {.shadow = false}); }),
            0);
  EXPECT_EQ(alpha_under([](SceneMaker& maker) { add_plate(maker, maker.diffuse(0.5), catching); }),
            0);
  EXPECT_EQ(alpha_under([](SceneMaker& maker) { add_plate(maker, veil(maker, 0.25)); }), 0.25);
  EXPECT_EQ(alpha_under([](SceneMaker& maker) {
              add_plate(maker, veil(maker, 0.25), catching);
              add_plate(maker, veil(maker, 0.5));
            }),
            0.5);
}

TEST(ShadowCatcher, IsSeenThroughWhatIsNotThereAndHidesWhatIsBehind) {
  const auto above = [](double share, bool shadowed = true) {
    return alpha_under([&](SceneMaker& maker) {
      maker.add(veil(maker, share), scene::Quad{{-0.5, 5, 0.5}, {1, 0, 0}, {0, 0, -1}});
      if (shadowed) add_plate(maker, maker.diffuse(0.5));
      maker.add(maker.emitter(3), scene::Quad{{-1, -1, 1}, {2, 0, 0}, {0, 0, -2}});
    });
  };
  EXPECT_EQ(above(0), 1);
  EXPECT_EQ(above(0.5), 1) << "the veil by one half, the shadow by the other";
  EXPECT_NEAR(above(0.5, false), 0.5, 0.2) << "the veil alone";
  EXPECT_EQ(alpha_under([](SceneMaker& maker) {
              maker.add(maker.emitter(3, true), scene::Quad{{-1, -1, 1}, {2, 0, 0}, {0, 0, -2}});
            }),
            0);
}

TEST(ShadowCatcher, HasAsManyRaysUnderWhateverStandsAboveIt) {
  const auto rays = [](const Visibility& visibility, bool veiled) {
    SceneMaker maker;
    maker.add(maker.diffuse(0.5), ground());
    maker.description.shapes.back().visibility = catching;
    add_lights_of_all_kinds(maker);
    const std::uint32_t material = veiled ? veil(maker, 0.5) : maker.diffuse(0.5);
    for (int i = 0; i < 20; ++i) {
      maker.add(material, scene::Quad{{-20, 1 + 0.1 * i, 20}, {40, 0, 0}, {0, 0, -40}});
      maker.description.shapes.back().visibility = visibility;
    }
    maker.look({0, 0.9, 0.5}, {0, 0, 0}, 30, {0, 1, 0});
    TaskRequest request = request_for(4);
    request.settings.bounces = 0;
    tbb::task_arena arena(2);
    const auto done = render_task(maker.build(), request, arena);
    EXPECT_GT(caught(done->image, unshadowed_R, 0), 0);
    return static_cast<double>(done->stats.rays) / static_cast<double>(done->stats.samples);
  };
  // The camera's, a light sample's with and without what is no catcher, the catcher's own.
  EXPECT_LE(rays({}, false), 4);
  EXPECT_LE(rays({}, true), 4);
  EXPECT_LE(rays(catching, true), 4);
}

TEST(ShadowCatcher, ThatNoLightReachesHasNoShadow) {
  const auto dark = [](SceneMaker& maker) { maker.description.lights.clear(); };
  EXPECT_EQ(alpha_under(dark), 0);
  EXPECT_EQ(alpha_under([&](SceneMaker& maker) {
              dark(maker);
              add_plate(maker, maker.diffuse(0.5));
            }),
            0);
}

TEST(ShadowCatcher, IsAnOrdinarySurfaceToScatteredRays) {
  const auto in_mirror = [](const Visibility& visibility) {
    SceneMaker maker;
    maker.add(maker.mirror(1), scene::Quad{{-1, -1, 1}, {2, 0, -2}, {0, 2, 0}});
    maker.add(maker.emitter(3, true), scene::Quad{{5, -5, -5}, {0, 0, 10}, {0, 10, 0}});
    maker.description.shapes.back().visibility = visibility;
    maker.description.film_transparent = true;
    maker.look({0, 0, 5}, {0, 0, 0}, 0.001, {0, 1, 0});
    TaskRequest request = request_for(4);
    request.settings.bounces = 2;
    const image::TileImage image = taken(maker.build(), request);
    EXPECT_EQ(caught(image, caught_coverage, 0), 0);
    EXPECT_EQ(image.plane(image::A)[0], 1);
    return image.plane(image::R)[0];
  };
  EXPECT_EQ(in_mirror(catching), 3);
  EXPECT_EQ(in_mirror({.indirect = false, .shadow_catcher = true}), 0);
}

TEST(ShadowCatcher, MayBeOneOfSeveralInstances) {
  SceneMaker maker;
  maker.description.objects = {{"plate", {}}};
  maker.add(maker.diffuse(0.5), scene::Quad{{-1, 0, 1}, {2, 0, 0}, {0, 0, -2}});
  maker.description.objects.front().shapes = std::move(maker.description.shapes);
  maker.description.shapes.clear();
  const auto place = [&](double x, double y, const Visibility& visibility) {
    maker.description.instances.push_back({0, translate(x, y, 0), visibility});
  };
  place(0, 0, catching);
  place(5, 0, {});
  place(-2, 2, {});
  maker.description.lights.push_back({"s", scene::DirectionalLight{{1, -1, 0}, {2, 2, 2}, 0}});
  maker.description.film_transparent = true;
  const auto seen_at = [&](double x) {
    maker.look({x, 10, 0.1}, {x, 0, 0}, 0.01, {0, 0, -1});
    const image::TileImage image = taken(maker);
    return std::pair(alpha(image, 0), caught(image, caught_coverage, 0));
  };
  EXPECT_EQ(seen_at(0), std::pair(1.0, 1.0F));
  EXPECT_EQ(seen_at(5), std::pair(1.0, 0.0F));
  maker.description.instances.back().visibility = catching;
  EXPECT_EQ(seen_at(0), std::pair(0.0, 1.0F));
}

TEST(ShadowCatcher, TravelsWithEveryPassAndHasTheSameBitsHoweverTheFilmIsCut) {
  SceneMaker maker = ball_over_ground();
  add_lights_of_all_kinds(maker);
  const Scene scene = maker.build();
  TaskRequest request = request_for(8);
  const image::TileImage whole = taken(scene, request, 1);
  request.aovs = false;
  const std::size_t first = first_of(whole);
  const image::TileImage late = taken(scene, request);
  request.window = {5, 7, 11, 9};
  const image::TileImage part = taken(scene, request);
  for (std::size_t c = first; c < first + caught_channel_count; ++c) {
    for (std::size_t i = 0; i < whole.pixels(); ++i) ASSERT_EQ(late.plane(c)[i], whole.plane(c)[i]);
    for (std::size_t y = 0; y < 9; ++y)
      for (std::size_t x = 0; x < 11; ++x)
        ASSERT_EQ(part.plane(c)[y * 11 + x], whole.plane(c)[(y + 7) * side + x + 5]);
  }
}

TEST(ShadowCatcher, IsRefusedToAJobThatDoesNotCarryIt) {
  SceneMaker maker = ball_over_ground();
  const Scene scene = maker.build();
  TaskRequest request = request_for(4);
  EXPECT_NO_THROW(check_request(scene, request));
  request.settings.aovs = {};
  try {
    check_request(scene, request);
    FAIL() << "it was taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::bad_input);
    EXPECT_STREQ(error.what(),
                 "render.aovs: the scene has shadow catchers: expected \"shadow_catcher\" among "
                 "the AOVs, in which their shadows travel");
  }
  maker.description.shapes.front().visibility = {.holdout = true};
  EXPECT_NO_THROW(check_request(maker.build(), request));
}

}  // namespace
}  // namespace tessera::render::proof
