#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "tests/render/shadow_catchers.hpp"

/// Shadow catchers: the light that would leave them if they were white, with and without shadows.
namespace tessera::render::proof {
namespace {

using namespace catchers;

/// A lamp by a picture of four texels.
void add_painted_lamp(SceneMaker& maker) {
  scene::Scene& scene = maker.description;
  scene.images = {picture_of(2, {5, -3, 1, 3})};
  scene.textures = {{.image = 0, .nearest = true}};
  scene::Principled surface;
  surface.base_color.factor = {0, 0, 0};
  surface.specular.factor = 0;
  surface.emission = {.factor = {1, 1, 1}, .texture = scene::TextureUse{}};
  scene.materials.push_back({"painted", surface});
  maker.add(static_cast<std::uint32_t>(scene.materials.size() - 1),
            scene::Quad{{-2, 4, -1}, {1, 0, 0}, {0, 0, 1}});
  // Else it stands before other lights.
  scene.shapes.back().visibility = {.camera = false, .shadow = false};
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
    {"PaintedLamp", add_painted_lamp},
    {"All", add_lights_of_all_kinds},
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

/// Fails unless it notes what a white surface shows `with` what shadows it and `without`, by the
/// same samples, so that there is no noise between them.
void expect_caught(const image::TileImage& image, const image::TileImage& with,
                   const image::TileImage& without) {
  std::size_t whole = 0, dark = 0;
  for (std::size_t i = 0; i < image.pixels(); ++i) {
    if (caught(image, caught_coverage, i) < 1) continue;
    ++whole;
    const float lit = with.plane(image::R)[i], open = without.plane(image::R)[i];
    ASSERT_NEAR(caught(image, caught_R, i), lit, 1e-5 * open) << i;
    ASSERT_NEAR(caught(image, unshadowed_R, i), open, 1e-5 * open) << i;
    if (lit < 0.8F * open) ++dark;
  }
  EXPECT_GT(whole, image.pixels() / 2);
  EXPECT_GT(dark, 8U);
}

TEST_P(ACatcherUnder, NotesTheDirectLightOnAWhiteSurfaceWithAndWithoutWhatShadowsIt) {
  SceneMaker maker = ball_over_ground();
  GetParam().add(maker);
  for (const int light_samples : {1, 3}) {
    SCOPED_TRACE(light_samples);
    const auto image_of = [&](const SceneMaker& of) {
      TaskRequest request = request_for(64);
      request.settings.light_samples = light_samples;
      return taken(of.build(), request);
    };
    expect_caught(image_of(maker), image_of(white_ground(GetParam(), true)),
                  image_of(white_ground(GetParam(), false)));
  }
}

/// Grounds that are not flat, stand elsewhere than they were made, or let light in.
struct Ground {
  const char* name;
  std::function<void(SceneMaker&, std::uint32_t material)> add;
};
void PrintTo(const Ground& of, std::ostream* out) { *out << of.name; }

const std::vector<Ground> grounds{
    {"SmoothMeshOfFewFaces",
     [](SceneMaker& maker, std::uint32_t material) {
       maker.add(material, ball(2, true), translate(0, -14, 0) * scale(14, 14, 14));
     }},
    {"Instance",
     [](SceneMaker& maker, std::uint32_t material) {
       maker.description.objects = {{"ground", {{"quad", ground(), material, {}}}}};
       maker.description.instances = {{0, rotate({0, 1, 0}, 30) * scale(0.7, 1, 0.7), {}}};
     }},
    {"BlockOfGlass",
     [](SceneMaker& maker, std::uint32_t material) {
       maker.add(material, scene::Box{{-20, -2, -20}, {20, 0, 20}});
     }},
};

class ACatcherThatIs : public testing::TestWithParam<Ground> {};
INSTANTIATE_TEST_SUITE_P(Grounds, ACatcherThatIs, testing::ValuesIn(grounds),
                         [](const auto& of) { return std::string(of.param.name); });

TEST_P(ACatcherThatIs, NotesWhatAWhiteSurfaceOfItsShapeShows) {
  const auto image_of = [&](bool catches, bool shadowed) {
    SceneMaker maker;
    const std::uint32_t material = catches ? maker.dielectric(1.5) : maker.diffuse(1);
    if (catches) {
      auto& glass = std::get<scene::Dielectric>(maker.description.materials[material].surface);
      glass.attenuation_color = {0.5, 0.5, 0.5};
      glass.attenuation_distance = 0.1;
    }
    GetParam().add(maker, material);
    for (scene::Shape& shape : maker.description.shapes) shape.visibility.shadow_catcher = catches;
    for (scene::Instance& instance : maker.description.instances)
      instance.visibility.shadow_catcher = catches;
    if (shadowed) maker.add(maker.diffuse(0.25), scene::Sphere{{0, 1, 0}, 0.7});
    maker.look({0, 5, 7}, {0, 0.5, 0}, 40, {0, 1, 0});
    maker.description.film_transparent = true;
    add_lights_of_all_kinds(maker);
    add_painted_lamp(maker);
    return taken(maker, 64);
  };
  expect_caught(image_of(true, true), image_of(false, true), image_of(false, false));
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

double luminance(const std::array<double, 3>& color) {
  return 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2];
}
double quotient(double shadowed, double open) { return open > 0 ? shadowed / open : 1; }

/// A pixel laid over a background with the colours of its shadow, as scenes/README.md has it.
std::array<double, 3> laid_over(const image::TileImage& image, std::size_t pixel,
                                const std::array<double, 3>& background) {
  std::array<double, 3> shadowed{}, open{}, out{};
  for (std::size_t c = 0; c < 3; ++c) {
    shadowed.at(c) = caught(image, static_cast<CaughtChannel>(caught_R + c), pixel);
    open.at(c) = caught(image, static_cast<CaughtChannel>(unshadowed_R + c), pixel);
  }
  const double lit = quotient(luminance(shadowed), luminance(open));
  const double coverage = caught(image, caught_coverage, pixel);
  const double of_picture = image.plane(image::A)[pixel] + coverage * (1 - lit);
  for (std::size_t c = 0; c < 3; ++c)
    out.at(c) = image.plane(image::R + c)[pixel] +
                background.at(c) *
                    ((1 - of_picture) + coverage * (quotient(shadowed.at(c), open.at(c)) - lit));
  return out;
}

TEST(ShadowCatcher, LaidOverWithItsColoursShadowsEachByItself) {
  // The pixel's left half shows the catcher, its lower half a plate that hides no light. A red sun
  // is behind another plate, a blue one is not, and nothing is green.
  SceneMaker maker;
  maker.add(maker.diffuse(0.5), scene::Quad{{-20, 0, 20}, {20, 0, 0}, {0, 0, -40}});
  maker.description.shapes.back().visibility = catching;
  maker.add(maker.diffuse(0.5), scene::Quad{{-1, 5, 2}, {2, 0, 0}, {0, 0, -2}});
  maker.description.shapes.back().visibility = {.shadow = false, .indirect = false};
  maker.add(maker.diffuse(0.5), scene::Quad{{-5, 2, 3}, {4, 0, 0}, {0, 0, -6}});
  maker.description.shapes.back().visibility = {.camera = false};
  maker.description.lights = {{"red", scene::DirectionalLight{{1, -1, 0}, {3, 0, 0}, 0}},
                              {"blue", scene::DirectionalLight{{-1, -1, 0}, {0, 0, 2}, 0}}};
  maker.description.film_transparent = true;
  maker.look({0, 10, 0}, {0, 0, 0}, 0.01, {0, 0, -1});
  TaskRequest request = request_for(256);
  request.settings.width = request.settings.height = 1;
  request.window = {0, 0, 1, 1};
  const image::TileImage image = taken(maker.build(), request);
  const double seen = image.plane(image::A)[0], coverage = caught(image, caught_coverage, 0);
  ASSERT_NEAR(seen, 0.5, 0.1);
  ASSERT_NEAR(coverage, 0.25, 0.1);
  const std::array<double, 3> photograph{0.25, 0.5, 2}, shown{0, 1, 1};
  const std::array<double, 3> over = laid_over(image, 0, photograph);
  for (std::size_t c = 0; c < 3; ++c) {
    const double behind = 1 - seen - coverage + coverage * shown.at(c);
    EXPECT_NEAR(over.at(c), image.plane(image::R + c)[0] + photograph.at(c) * behind, 1e-6) << c;
  }
  EXPECT_GT(image.plane(image::R)[0], 0.1);
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

}  // namespace
}  // namespace tessera::render::proof
