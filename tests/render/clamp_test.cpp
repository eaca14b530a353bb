#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "tests/render/support.hpp"

/// Light that is clamped, as a picture has it: off unless asked for, and then the brightest
/// contributions alone are darker.
namespace tessera::render::proof {
namespace {

/// A corner of floor and wall under a bulb close to the wall, coloured so that a contribution's
/// mean is none of its channels. With one bounce a sample has one direct contribution and at most
/// one indirect one: the bulb is found by light samples alone.
Scene corner_under_a_bulb() {
  SceneMaker maker;
  maker.description.materials = {{"m0", scene::Diffuse{{0.9, 0.6, 0.3}}},
                                 {"m1", scene::Diffuse{{0.5, 0.8, 0.7}}}};
  maker.add(0, scene::Quad{{-3, 0, 3}, {6, 0, 0}, {0, 0, -6}});
  maker.add(1, scene::Quad{{-3, 0, -1}, {6, 0, 0}, {0, 6, 0}});
  maker.description.lights.push_back(
      {.name = "bulb", .shape = scene::PointLight{{0, 0.4, -0.8}, {3, 2, 1}}});
  maker.look({0, 2, 4}, {0, 0.5, -0.5}, 50);
  return maker.build();
}

/// One sample a pixel, so that a pixel's `direct` and `indirect` are single contributions.
image::TileImage seen(double clamp_direct, double clamp_indirect) {
  static const Scene scene = corner_under_a_bulb();
  TaskRequest request = request_of({.side = 32, .samples = 1, .bounces = 1}, 3);
  request.settings.aovs = {"direct", "indirect"};
  request.settings.clamp_direct = clamp_direct;
  request.settings.clamp_indirect = clamp_indirect;
  tbb::task_arena arena(2);
  std::optional<RenderedTask> done = render_task(scene, request, arena);
  return std::move(done.value().image);
}

Color color_of(const image::TileImage& image, const std::string& part, std::size_t pixel) {
  const auto channel = [&](const char* component) {
    const int index = image.layout->index_of(part + component);
    EXPECT_GE(index, 0) << part;
    return index < 0 ? 0 : image.plane(static_cast<std::size_t>(index))[pixel];
  };
  return {channel("R"), channel("G"), channel("B")};
}

double mean_of(const Color& color) {
  return (double{color.r} + double{color.g} + double{color.b}) / 3;
}

/// A level that a tenth of the pixels exceeds, so that the clamp has something to do and something
/// to leave; no pixel is so near to it that rounding decides.
double exceeded_by_a_tenth(const image::TileImage& image, const std::string& part) {
  std::vector<double> means;
  for (std::size_t pixel = 0; pixel < image.pixels(); ++pixel)
    means.push_back(mean_of(color_of(image, part, pixel)));
  std::sort(means.begin(), means.end());
  const std::size_t above = means.size() - means.size() / 10;
  const double limit = 0.5 * (means[above - 1] + means[above]);
  EXPECT_GT(means[above], limit * (1 + 1e-6)) << part;
  EXPECT_LT(means[above - 1], limit * (1 - 1e-6)) << part;
  return limit;
}

/// How many pixels of a part were darkened. Each has as much as the clamp allows, and its colour.
std::size_t expect_clamped(const image::TileImage& clamped, const image::TileImage& free,
                           const std::string& part, double limit) {
  std::size_t darkened = 0;
  for (std::size_t pixel = 0; pixel < free.pixels(); ++pixel) {
    const Color before = color_of(free, part, pixel), after = color_of(clamped, part, pixel);
    if (mean_of(before) <= limit) {
      EXPECT_EQ(after, before) << part << ", pixel " << pixel;
      continue;
    }
    ++darkened;
    const double share = limit / mean_of(before);
    EXPECT_NEAR(after.r, before.r * share, 1e-6 * limit) << part << ", pixel " << pixel;
    EXPECT_NEAR(after.g, before.g * share, 1e-6 * limit) << part << ", pixel " << pixel;
    EXPECT_NEAR(after.b, before.b * share, 1e-6 * limit) << part << ", pixel " << pixel;
  }
  return darkened;
}

void expect_untouched(const image::TileImage& image, const image::TileImage& free,
                      const std::string& part) {
  for (std::size_t pixel = 0; pixel < free.pixels(); ++pixel)
    ASSERT_EQ(color_of(image, part, pixel), color_of(free, part, pixel)) << part << ' ' << pixel;
}

TEST(Clamp, OfIndirectLightDarkensItsBrightestContributionsAlone) {
  const image::TileImage free = seen(0, 0);
  const double limit = exceeded_by_a_tenth(free, "indirect.");
  const image::TileImage clamped = seen(0, limit);
  EXPECT_EQ(expect_clamped(clamped, free, "indirect.", limit), free.pixels() / 10);
  expect_untouched(clamped, free, "direct.");
}

TEST(Clamp, OfDirectLightDarkensItsBrightestContributionsAlone) {
  const image::TileImage free = seen(0, 0);
  const double limit = exceeded_by_a_tenth(free, "direct.");
  const image::TileImage clamped = seen(limit, 0);
  EXPECT_EQ(expect_clamped(clamped, free, "direct.", limit), free.pixels() / 10);
  expect_untouched(clamped, free, "indirect.");
}

TEST(Clamp, ThatNothingExceedsChangesNoBit) {
  const image::TileImage free = seen(0, 0), clamped = seen(1e6, 1e6);
  EXPECT_GT(exceeded_by_a_tenth(free, "indirect."), 0);
  EXPECT_EQ(clamped.values, free.values);
  TaskRequest unasked;
  EXPECT_EQ(unasked.settings.clamp_direct, 0);
  EXPECT_EQ(unasked.settings.clamp_indirect, 0);
}

}  // namespace
}  // namespace tessera::render::proof
