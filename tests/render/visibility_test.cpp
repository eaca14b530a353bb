#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "tests/render/support.hpp"

/// What is hidden from some rays, held out, or not seen behind a transparent film.
namespace tessera::render::proof {
namespace {

using scene::Visibility;

constexpr int side = 24;
constexpr double floor_albedo = 0.5, ball_albedo = 0.25;

/// A floor, and a ball above it of this visibility, under a lamp that casts its shadow.
SceneMaker ball_above_floor(const Visibility& visibility) {
  SceneMaker maker;
  maker.add(maker.diffuse(floor_albedo), scene::Quad{{-20, 0, 20}, {40, 0, 0}, {0, 0, -40}});
  maker.add(maker.diffuse(ball_albedo), scene::Sphere{{0, 1, 0}, 0.7});
  maker.description.shapes.back().visibility = visibility;
  maker.add(maker.emitter(8), scene::Quad{{-1, 6, -1}, {2, 0, 0}, {0, 0, 2}});
  maker.look({0, 5, 7}, {0, 0.5, 0}, 40, {0, 1, 0});
  return maker;
}

image::TileImage taken(const SceneMaker& maker, int bounces = 4) {
  return render(maker.build(), {.side = side, .samples = 16, .bounces = bounces}, 5).image;
}

/// Which pixels show nothing but a surface of this albedo.
std::vector<bool> showing(const image::TileImage& image, double albedo) {
  std::vector<bool> out;
  for (const float seen : image.plane(image::albedo_R))
    out.push_back(seen == static_cast<float>(albedo));
  return out;
}

std::size_t count(const std::vector<bool>& pixels) {
  return static_cast<std::size_t>(std::count(pixels.begin(), pixels.end(), true));
}

/// Fails unless both have the same bits in all channels of these pixels.
void expect_same(const image::TileImage& a, const image::TileImage& b,
                 const std::vector<bool>& pixels) {
  for (std::size_t c = 0; c < a.channels(); ++c) {
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (!pixels[i]) continue;
      ASSERT_EQ(a.plane(c)[i], b.plane(c)[i]) << "channel " << c << " pixel " << i;
    }
  }
}

void expect_same(const image::TileImage& a, const image::TileImage& b) {
  expect_same(a, b, std::vector<bool>(a.pixels(), true));
}

bool differs(const image::TileImage& a, const image::TileImage& b, std::size_t channel) {
  const auto left = a.plane(channel), right = b.plane(channel);
  return std::memcmp(left.data(), right.data(), left.size_bytes()) != 0;
}

TEST(HiddenFromTheCamera, WhatItShadowsAndLightsHasTheBitsItHasBesideItsPicture) {
  const image::TileImage seen = taken(ball_above_floor({}));
  const image::TileImage hidden = taken(ball_above_floor({.camera = false}));
  const std::vector<bool> beside = showing(seen, floor_albedo);
  EXPECT_GT(count(beside), seen.pixels() / 2);
  EXPECT_LT(count(beside), seen.pixels() - 20);
  expect_same(hidden, seen, beside);
  EXPECT_EQ(count(showing(hidden, floor_albedo)), hidden.pixels()) << "it is nowhere seen";
}

TEST(HiddenFromTheCamera, AMirrorShowsIt) {
  const auto before_mirror = [](const Visibility& visibility) {
    SceneMaker maker;
    maker.add(maker.mirror(1), scene::Quad{{-1, -1, 1}, {2, 0, -2}, {0, 2, 0}});
    maker.add(maker.emitter(3, true), scene::Quad{{5, -5, -5}, {0, 0, 10}, {0, 10, 0}});
    maker.description.shapes.back().visibility = visibility;
    maker.look({0, 0, 5}, {0, 0, 0}, 0.001, {0, 1, 0});
    return render(maker.build(), {.side = 1, .samples = 4, .bounces = 2}, 1)
        .image.plane(image::R)[0];
  };
  EXPECT_EQ(before_mirror({}), 3);
  EXPECT_EQ(before_mirror({.camera = false}), 3);
  EXPECT_EQ(before_mirror({.shadow = false}), 3);
  EXPECT_EQ(before_mirror({.indirect = false}), 0);
}

TEST(HiddenFromTheCamera, ItStaysSoBehindWhatIsNotThere) {
  const auto behind_nothing = [](const Visibility& visibility) {
    SceneMaker maker;
    maker.add(maker.diffuse(0.5), scene::Quad{{-1, -1, 2}, {2, 0, 0}, {0, 2, 0}});
    maker.description.materials.back().opacity = {.mode = scene::Opacity::Mode::blend,
                                                  .alpha = {.factor = 0}};
    maker.add(maker.emitter(3), scene::Quad{{-1, -1, 1}, {2, 0, 0}, {0, 2, 0}});
    maker.description.shapes.back().visibility = visibility;
    maker.add(maker.emitter(7), scene::Quad{{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}});
    return render(maker.build(), {.side = 1, .samples = 4}, 1).image.plane(image::R)[0];
  };
  EXPECT_EQ(behind_nothing({}), 3);
  EXPECT_EQ(behind_nothing({.camera = false}), 7);
}

TEST(HiddenFromShadowRays, DirectLightIsAsIfItWereNotThere) {
  SceneMaker with = ball_above_floor({.shadow = false});
  with.description.images = {picture_of(1, {3, -4})};
  with.description.environment = scene::Environment{.radiance = {1, 1, 1}, .image = 0};
  SceneMaker without = with;
  without.description.shapes.erase(without.description.shapes.begin() + 1);
  const image::TileImage alone = taken(without, 0), beside_it = taken(with, 0);
  const std::vector<bool> beside = showing(beside_it, floor_albedo);
  EXPECT_GT(count(beside), alone.pixels() / 2);
  EXPECT_LT(count(beside), alone.pixels() - 20);
  expect_same(beside_it, alone, beside);
}

/// Light on a point of the floor, of albedo 0.8, from whatever is above it.
class OnTheFloor {
 public:
  OnTheFloor() {
    maker.add(maker.diffuse(0.8), scene::Quad{{-50, 0, 50}, {100, 0, 0}, {0, 0, -100}});
    maker.look({6, 2, 0.3}, {0, 0, 0});
  }
  void add(std::uint32_t material, double radius, const Visibility& visibility) {
    maker.add(material, scene::Sphere{{0, 1, 0}, radius});
    maker.description.shapes.back().visibility = visibility;
  }
  /// By each of the integrators that find such light.
  void expect(double radiance, int bounces = 0) const {
    const Scene scene = maker.build();
    for (const char* integrator : {"path", "cosine", "hemisphere_lights", "hemisphere"}) {
      SCOPED_TRACE(integrator);
      expect_mean(measure(scene, {.samples = 512, .bounces = bounces, .integrator = integrator}),
                  radiance);
    }
  }
  SceneMaker maker;
};

TEST(HiddenFromShadowRays, TheSkyLightsTheFloorThroughItByEveryIntegrator) {
  OnTheFloor floor;
  floor.maker.environment(1);
  floor.add(floor.maker.diffuse(0), 0.5, {.shadow = false});
  floor.expect(0.8);
}

TEST(HiddenFromScatteredRays, ItStillShadowsByEveryIntegrator) {
  OnTheFloor floor;
  floor.maker.environment(1);
  // A ball of radius r whose middle is at height h above a point covers (r/h)² of its sky.
  floor.add(floor.maker.diffuse(0.9), 0.5, {.indirect = false});
  floor.expect(0.8 * 0.75, 3);
}

TEST(HiddenFromAllRays, ALampLightsByEveryIntegrator) {
  OnTheFloor floor;
  floor.add(floor.maker.emitter(2), 0.8, {.camera = false, .shadow = false, .indirect = false});
  floor.expect(0.8 * 2 * 0.64, 2);
}

TEST(HiddenFromShadowRays, ALampAddsItsLightToWhatComesFromBehindIt) {
  OnTheFloor floor;
  floor.maker.environment(1);
  floor.add(floor.maker.emitter(2), 0.8, {.shadow = false});
  // Both its near and its far side: the far one faces away.
  floor.expect(0.8 * (1 + 2 * 0.64));
}

TEST(HiddenFromShadowRays, AnInterfaceThatCountsForNothingLetsLightThroughOnce) {
  for (const bool shadow : {true, false}) {
    SCOPED_TRACE(shadow);
    OnTheFloor floor;
    const std::uint32_t air = floor.maker.dielectric(1), glass = floor.maker.dielectric(1.5);
    floor.maker.description.materials[air].priority = 1;
    floor.maker.add(air, scene::Box{{-3, -1, -3}, {3, 3, 3}});
    floor.add(glass, 0.9, {.shadow = shadow});
    floor.add(floor.maker.emitter(2), 0.8, {});
    floor.expect(0.8 * 2 * 0.64, 1);
  }
}

TEST(Holdout, IsAHoleThatStillShadows) {
  const image::TileImage seen = taken(ball_above_floor({}));
  const image::TileImage held = taken(ball_above_floor({.holdout = true}));
  expect_same(held, seen, showing(seen, floor_albedo));
  const std::vector<bool> hole = showing(seen, ball_albedo);
  ASSERT_GT(count(hole), 10U);
  for (std::size_t i = 0; i < hole.size(); ++i) {
    if (!hole[i]) continue;
    for (std::size_t c = 0; c < held.channels(); ++c)
      ASSERT_EQ(held.plane(c)[i], c == image::Z ? image::nothing_hit_z : 0) << c;
  }
  EXPECT_TRUE(differs(held, taken(ball_above_floor({.shadow = false, .holdout = true})), image::R));
}

TEST(Holdout, HidesWhatIsBehindItAndIsSeenInMirrors) {
  SceneMaker maker;
  maker.environment(1);
  maker.add(maker.emitter(3, true), scene::Quad{{-1, -1, 1}, {2, 0, 0}, {0, 2, 0}});
  maker.description.shapes.back().visibility.holdout = true;
  const auto seen = [&](std::size_t channel) {
    return render(maker.build(), {.side = 1, .samples = 4, .bounces = 2}, 1)
        .image.plane(channel)[0];
  };
  EXPECT_EQ(seen(image::R), 0);
  EXPECT_EQ(seen(image::A), 0);
  maker.add(maker.mirror(1), scene::Quad{{-1, -1, 2}, {2, 0, 0}, {0, 2, 0}});
  maker.look({0, 0, 1.5}, {0, 0, 2});
  EXPECT_EQ(seen(image::R), 3);
  EXPECT_EQ(seen(image::A), 1);
}

TEST(TransparentFilm, ShowsNoSurroundingsAndIsLitByThem) {
  SceneMaker maker;
  maker.add(maker.diffuse(0.5), scene::Sphere{{0, 0, 0}, 1});
  maker.environment(2);
  maker.description.lights.push_back({"sun", scene::DirectionalLight{{0, 0, 1}, {1, 1, 1}, 60}});
  maker.look({0, 0, 5}, {0, 0, 0}, 40);
  const image::TileImage opaque = taken(maker);
  maker.description.film_transparent = true;
  const image::TileImage open = taken(maker);
  const std::vector<bool> ball = showing(opaque, 0.5);
  expect_same(open, opaque, ball);
  std::size_t background = 0;
  for (std::size_t i = 0; i < open.pixels(); ++i) {
    ASSERT_EQ(opaque.plane(image::A)[i], 1);
    const float alpha = open.plane(image::A)[i];
    // What the surroundings brought is at least 2 where they are seen.
    ASSERT_LE(open.plane(image::R)[i], opaque.plane(image::R)[i] - 2 * (1 - alpha) + 1e-5F);
    if (alpha > 0) continue;
    ++background;
    ASSERT_EQ(open.plane(image::R)[i], 0);
  }
  EXPECT_GT(background, 20U);
  EXPECT_GT(count(ball), 20U);
}

TEST(HiddenThings, HaveTheSameBitsHoweverTheFilmIsCut) {
  SceneMaker maker = ball_above_floor({.shadow = false, .holdout = true});
  maker.add(maker.emitter(5), scene::Sphere{{2, 1, 0}, 0.3});
  maker.description.shapes.back().visibility = {
      .camera = false, .shadow = false, .indirect = false};
  maker.environment(0.3);
  maker.description.film_transparent = true;
  const Scene scene = maker.build();
  const Take take{.side = side, .samples = 4, .bounces = 4, .threads = 1};
  const image::TileImage whole = render(scene, take, 9).image;
  expect_same(render(scene, {.side = side, .samples = 4, .bounces = 4, .threads = 2}, 9).image,
              whole);
  TaskRequest request = request_of(take, 9);
  request.window = {5, 7, 11, 9};
  tbb::task_arena arena(2);
  const auto part = render_task(scene, request, arena);
  ASSERT_TRUE(part.has_value());
  for (std::size_t c = 0; c < whole.channels(); ++c)
    for (int y = 0; y < request.window.height; ++y)
      for (int x = 0; x < request.window.width; ++x)
        ASSERT_EQ(part->image.plane(c)[static_cast<std::size_t>(y * request.window.width + x)],
                  whole.plane(c)[static_cast<std::size_t>((y + 7) * side + x + 5)]);
}

}  // namespace
}  // namespace tessera::render::proof
