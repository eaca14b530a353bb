#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "tests/render/support.hpp"

/// Shadow catchers: the light that would leave them if they were white, with and without shadows.
namespace tessera::render::proof {
namespace {

using scene::Visibility;

constexpr Visibility catching{.shadow_catcher = true};
constexpr int side = 32;

scene::Quad ground() { return {{-20, 0, 20}, {40, 0, 0}, {0, 0, -40}}; }

/// A catching ground that is not white, and a ball above it.
SceneMaker ball_over_ground(const Visibility& of_ground = catching) {
  SceneMaker maker;
  maker.add(maker.diffuse(0.5), ground());
  maker.description.shapes.back().visibility = of_ground;
  maker.add(maker.diffuse(0.25), scene::Sphere{{0, 1, 0}, 0.7});
  maker.look({0, 5, 7}, {0, 0.5, 0}, 40, {0, 1, 0});
  maker.description.film_transparent = true;
  return maker;
}

TaskRequest request_for(int samples, const std::string& integrator = "path") {
  TaskRequest request = request_of({.side = side, .samples = samples, .integrator = integrator}, 5);
  request.settings.aovs = {"albedo", "N", "Z", "P", "object_id", "shadow_catcher"};
  return request;
}

image::TileImage taken(const Scene& scene, const TaskRequest& request, int threads = 2) {
  tbb::task_arena arena(threads);
  auto done = render_task(scene, request, arena);
  EXPECT_TRUE(done.has_value());
  EXPECT_EQ(done->stats.rejected, 0);
  return std::move(done->image);
}

image::TileImage taken(const SceneMaker& maker, int samples = 16) {
  return taken(maker.build(), request_for(samples));
}

std::size_t first_of(const image::TileImage& image) {
  return static_cast<std::size_t>(image.layout->index_of("shadow_catcher.R"));
}
float caught(const image::TileImage& image, CaughtChannel channel, std::size_t pixel) {
  return image.plane(first_of(image) + channel)[pixel];
}

/// What the picture's alpha is to be.
double alpha(const image::TileImage& image, std::size_t pixel) {
  const double open = caught(image, unshadowed_G, pixel);
  const double lit = open > 0 ? caught(image, caught_G, pixel) / open : 1;
  return image.plane(image::A)[pixel] + caught(image, caught_coverage, pixel) * (1 - lit);
}

/// The lights that a ground may have.
struct Lit {
  const char* name;
  std::function<void(SceneMaker&)> add;
};
void PrintTo(const Lit& lit, std::ostream* out) { *out << lit.name; }

const std::vector<Lit> all_lights{
    {"Point",
     [](SceneMaker& maker) {
       maker.description.lights.push_back({"p", scene::PointLight{{2, 4, 1}, {50, 50, 50}}});
     }},
    {"Quad",
     [](SceneMaker& maker) {
       maker.add(maker.emitter(8), scene::Quad{{-1, 6, -1}, {2, 0, 0}, {0, 0, 2}});
     }},
    {"Sphere",
     [](SceneMaker& maker) {
       maker.add(maker.emitter(8), scene::Sphere{{-2, 3.5, 0}, 0.8});
       maker.description.shapes.back().visibility.camera = false;
     }},
    {"Sun",
     [](SceneMaker& maker) {
       maker.description.lights.push_back(
           {"s", scene::DirectionalLight{{1, -2, 0.5}, {3, 3, 3}, 8}});
     }},
    {"Sky", [](SceneMaker& maker) { maker.environment(1); }},
    // What is below its mean is found by no light sample.
    {"PictureOfASky",
     [](SceneMaker& maker) {
       maker.description.images = {picture_of(4, {4, -3, -2, -1, -3, -3, -2, 0})};
       maker.description.environment = scene::Environment{.radiance = {1, 1, 1}, .image = 0};
     }},
    {"All",
     [](SceneMaker& maker) {
       maker.environment(0.5);
       maker.add(maker.emitter(8), scene::Quad{{-1, 6, -1}, {2, 0, 0}, {0, 0, 2}});
       // Else it stands before the sky.
       maker.description.shapes.back().visibility.shadow = false;
       maker.description.lights.push_back({"p", scene::PointLight{{2, 4, 1}, {50, 50, 50}}});
     }},
};

class ACatcherUnder : public testing::TestWithParam<Lit> {};
INSTANTIATE_TEST_SUITE_P(Lights, ACatcherUnder, testing::ValuesIn(all_lights),
                         [](const auto& lit) { return std::string(lit.param.name); });

/// A white surface in its place, with what shadows it and without.
SceneMaker white_ground(const Lit& lit, bool shadowed) {
  SceneMaker maker;
  maker.add(maker.diffuse(1), ground());
  maker.add(maker.diffuse(0.25), scene::Sphere{{0, 1, 0}, 0.7});
  if (!shadowed) maker.description.shapes.pop_back();
  maker.look({0, 5, 7}, {0, 0.5, 0}, 40, {0, 1, 0});
  lit.add(maker);
  return maker;
}

TEST_P(ACatcherUnder, NotesTheDirectLightOnAWhiteSurfaceWithAndWithoutWhatShadowsIt) {
  SceneMaker maker = ball_over_ground();
  GetParam().add(maker);
  const image::TileImage image = taken(maker, 64);
  const image::TileImage with = taken(white_ground(GetParam(), true), 64);
  const image::TileImage without = taken(white_ground(GetParam(), false), 64);
  std::size_t whole = 0, dark = 0;
  for (std::size_t i = 0; i < image.pixels(); ++i) {
    if (caught(image, caught_coverage, i) < 1) continue;
    ++whole;
    // The same samples, so there is no noise between them.
    const float lit = with.plane(image::R)[i], open = without.plane(image::R)[i];
    ASSERT_NEAR(caught(image, caught_R, i), lit, 1e-5 * open) << i;
    ASSERT_NEAR(caught(image, unshadowed_R, i), open, 1e-5 * open) << i;
    if (lit < 0.8F * open) ++dark;
  }
  EXPECT_GT(whole, image.pixels() / 2);
  EXPECT_GT(dark, 8U);
}

TEST_P(ACatcherUnder, IsTheSameByEveryIntegrator) {
  SceneMaker maker = ball_over_ground();
  GetParam().add(maker);
  const Scene scene = maker.build();
  const image::TileImage image = taken(scene, request_for(4));
  for (const char* integrator : {"cosine", "hemisphere_lights", "hemisphere"}) {
    const image::TileImage other = taken(scene, request_for(4, integrator));
    for (std::size_t c = first_of(image); c < first_of(image) + caught_channel_count; ++c)
      for (std::size_t i = 0; i < image.pixels(); ++i)
        ASSERT_EQ(other.plane(c)[i], image.plane(c)[i]) << integrator << ' ' << c << ' ' << i;
  }
}

TEST_P(ACatcherUnder, LaidOverItsPictureIsThePictureWithAllInIt) {
  SceneMaker maker = ball_over_ground();
  GetParam().add(maker);
  const image::TileImage image = taken(maker, 64);
  // The photograph: the ground alone, as it is, by light that scatters once.
  SceneMaker real = ball_over_ground({});
  GetParam().add(real);
  real.description.film_transparent = false;
  SceneMaker empty = real;
  empty.description.shapes.erase(empty.description.shapes.begin() + 1);
  const image::TileImage picture = taken(real, 64), photograph = taken(empty, 64);
  double sum = 0;
  for (std::size_t i = 0; i < image.pixels(); ++i) {
    const double expected = picture.plane(image::R)[i], behind = photograph.plane(image::R)[i];
    const double over = image.plane(image::R)[i] + (1 - alpha(image, i)) * behind;
    const double error = std::abs(over - expected) / (behind + expected);
    // By the same samples, so without noise; but where the ball's outline crosses a pixel, its
    // ground is not all that the photograph shows there.
    const float coverage = caught(image, caught_coverage, i);
    ASSERT_LT(error, coverage == 0 || coverage == 1 ? 2e-5 : 0.1) << i;
    sum += error;
  }
  EXPECT_LT(sum / static_cast<double>(image.pixels()), 2e-3);
}

TEST(ShadowCatcher, HasAnEdgeWhereTheSunSaysSo) {
  SceneMaker maker = ball_over_ground();
  maker.description.lights.push_back({"s", scene::DirectionalLight{{1, -1, 0}, {2, 2, 2}, 0}});
  // Straight from above, a pixel a 16th across. The ball hides what is below it.
  maker.look({2, 50, 0}, {2, 0, 0}, 2 * std::atan(1.0 / 50) * 180 / pi_d, {0, 0, -1});
  const image::TileImage image = taken(maker);
  std::size_t in = 0, out = 0;
  for (std::size_t i = 0; i < image.pixels(); ++i) {
    if (caught(image, caught_coverage, i) < 1) continue;
    const double x = 2 + (static_cast<double>(i % side) + 0.5 - side / 2.0) / (side / 2.0);
    const double z = (static_cast<double>(i / side) + 0.5 - side / 2.0) / (side / 2.0);
    // The shadow of a ball of radius r under a sun 45° high is an ellipse, r·√2 long; its middle is
    // (1, 0).
    const double edge = std::hypot((x - 1) / std::sqrt(2.0), z) / 0.7;
    const double pixel = 0.08;
    const double a = alpha(image, i);
    if (edge < 1 - pixel) {
      ++in;
      ASSERT_EQ(a, 1) << x << ' ' << z;
    }
    if (edge > 1 + pixel) {
      ++out;
      ASSERT_EQ(a, 0) << x << ' ' << z;
    }
  }
  EXPECT_GT(in, 50U);
  EXPECT_GT(out, 200U);
}

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
  const auto above = [](double share) {
    return alpha_under([share](SceneMaker& maker) {
      maker.add(veil(maker, share), scene::Quad{{-0.5, 5, 0.5}, {1, 0, 0}, {0, 0, -1}});
      add_plate(maker, maker.diffuse(0.5));
      maker.add(maker.emitter(3), scene::Quad{{-1, -1, 1}, {2, 0, 0}, {0, 0, -2}});
    });
  };
  EXPECT_EQ(above(0), 1);
  EXPECT_EQ(alpha_under([](SceneMaker& maker) {
              maker.add(maker.emitter(3, true), scene::Quad{{-1, -1, 1}, {2, 0, 0}, {0, 0, -2}});
            }),
            0);
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
  all_lights.back().add(maker);
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
