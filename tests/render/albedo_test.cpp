#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "tests/render/support.hpp"
#include "worker/render/bsdf/fresnel.hpp"

/// What denoisers are told of glass, metal and lamps: their own albedo and normal, or those of what
/// is seen through them.
namespace tessera::render::proof {
namespace {

std::uint32_t add_material(SceneMaker& maker, scene::Material material) {
  material.name = "m" + std::to_string(maker.description.materials.size());
  maker.description.materials.push_back(std::move(material));
  return static_cast<std::uint32_t>(maker.description.materials.size() - 1);
}

constexpr scene::Color wall_color{0.2, 0.5, 0.75}, rear_color{0.9, 0.1, 0.3};
/// Its greatest is 1, so that no path ends by roulette.
constexpr scene::Color tint{1, 0.8, 0.6};

/// The camera looks along −z at a wall whose normal is (½, 0, √¾); one behind it faces −z. What is
/// to stand before the wall comes to the origin.
SceneMaker before_a_wall() {
  SceneMaker maker;
  const double cosine = std::sqrt(0.75);
  maker.add(add_material(maker, {"", scene::Diffuse{wall_color}}),
            scene::Quad{{-20 * cosine, -20, -5 + 10}, {40 * cosine, 0, -20}, {0, 40, 0}});
  maker.add(add_material(maker, {"", scene::Diffuse{rear_color}}),
            scene::Quad{{-20, -20, 9}, {0, 40, 0}, {40, 0, 0}});
  maker.look({0, 0, 5}, {0, 0, 0}, 0.001, {0, 1, 0});
  return maker;
}

image::TileImage seen(const Scene& scene, bool follow_specular, std::uint64_t seed,
                      std::int64_t samples) {
  TaskRequest request = request_of({.side = 1, .samples = samples, .bounces = 16}, seed);
  request.settings.aovs_follow_specular = follow_specular;
  tbb::task_arena arena(1);
  std::optional<RenderedTask> done = render_task(scene, request, arena);
  return std::move(done.value().image);
}

double value(const image::TileImage& image, const std::string& channel) {
  const int index = image.layout->index_of(channel);
  EXPECT_GE(index, 0) << channel;
  return index < 0 ? 0 : image.plane(static_cast<std::size_t>(index))[0];
}

/// Holds what is followed to shares of both walls: `passed` of the wall before the camera, each
/// channel's; `reflected` of the one behind it.
void expect_followed(const SceneMaker& maker, const scene::Color& passed,
                     const scene::Color& reflected) {
  const Scene scene = maker.build();
  std::array<std::vector<double>, 3> albedos;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const image::TileImage image = seen(scene, true, seed, 4096);
    albedos[0].push_back(value(image, "albedo.R"));
    albedos[1].push_back(value(image, "albedo.G"));
    albedos[2].push_back(value(image, "albedo.B"));
  }
  for (std::size_t c = 0; c < 3; ++c)
    expect_mean(estimate_of(albedos[c]), passed[c] * wall_color[c] + reflected[c] * rear_color[c]);
}

/// … and the normals to the shares of paths.
void expect_normals(const SceneMaker& maker, double passed, double reflected) {
  const Scene scene = maker.build();
  std::vector<double> across, along;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const image::TileImage image = seen(scene, true, seed, 4096);
    across.push_back(value(image, "N.X"));
    along.push_back(value(image, "N.Z"));
    EXPECT_NEAR(value(image, "N.Y"), 0, 1e-6);
  }
  expect_mean(estimate_of(across), passed * 0.5);
  expect_mean(estimate_of(along), passed * std::sqrt(0.75) - reflected);
}

scene::Color of_each(double (*function)(double tint)) {
  return {function(tint[0]), function(tint[1]), function(tint[2])};
}

/// What one interface of index 1.5 reflects along its normal.
constexpr double face = 0.04;

TEST(Albedo, ThroughATintedPaneIsTheWallsTimesItsColour) {
  SceneMaker maker = before_a_wall();
  scene::Dielectric pane;
  pane.transmittance = tint;
  pane.thin_walled = true;
  maker.add(add_material(maker, {"", pane}), scene::Quad{{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}});
  constexpr double both = 2 * face / (1 + face);
  expect_followed(maker, of_each([](double t) { return t * (1 - both); }), {both, both, both});
  expect_normals(maker, 1 - both, both);
}

TEST(Albedo, ThroughAClearBallIsTheWallsTimesWhatBothItsSidesLetThrough) {
  SceneMaker maker = before_a_wall();
  scene::Dielectric glass;
  glass.transmittance = tint;
  maker.add(add_material(maker, {"", glass}), scene::Sphere{{0, 0, 0}, 1});
  // To and fro between the sides, any number of times.
  constexpr double to_and_fro = 1 / (1 - face * face), in_and_out = (1 - face) * (1 - face);
  expect_followed(maker, of_each([](double t) { return t * t * in_and_out * to_and_fro; }),
                  of_each([](double t) { return face + t * t * in_and_out * face * to_and_fro; }));
  expect_normals(maker, in_and_out * to_and_fro, face + in_and_out * face * to_and_fro);
}

TEST(Albedo, OfWhatIsCastInGlassIsItsOwnTimesWhatOneSideLetsThrough) {
  SceneMaker maker = before_a_wall();
  maker.description.shapes.erase(maker.description.shapes.begin());
  scene::Dielectric glass;
  glass.transmittance = tint;
  maker.add(add_material(maker, {"", glass}), scene::Sphere{{0, 0, 0}, 1});
  maker.add(0, scene::Quad{{-0.3, -0.3, 0.1}, {0.6, 0, 0}, {0, 0.6, 0}});
  expect_followed(maker, of_each([](double t) { return t * (1 - face); }), {face, face, face});
}

TEST(Albedo, OfFrostedGlassIsItsOwnAlsoWherePathsGoOnThroughWhatIsClear) {
  SceneMaker maker = before_a_wall();
  scene::Dielectric frosted;
  frosted.transmittance = tint;
  frosted.roughness = 0.4;
  maker.add(add_material(maker, {"", frosted}), scene::Sphere{{0, 0, 0}, 1});
  const image::TileImage image = seen(maker.build(), true, 1, 16);
  for (const char* channel : {"albedo.R", "albedo.G", "albedo.B"})
    EXPECT_EQ(value(image, channel), 1) << channel;
  EXPECT_NEAR(value(image, "N.Z"), 1, 1e-5);
}

/// The cosine at which the camera sees what shows itself.
constexpr double aslant = 0.2;

/// What a square shows of itself that the camera sees from the side.
std::array<double, 3> own_albedo(scene::Material material) {
  SceneMaker maker;
  maker.add(add_material(maker, std::move(material)),
            scene::Quad{{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}});
  maker.look({5 * std::sqrt(1 - aslant * aslant), 0, 5 * aslant}, {0, 0, 0}, 0.001, {0, 1, 0});
  const image::TileImage image = seen(maker.build(), false, 1, 16);
  EXPECT_NEAR(value(image, "N.Z"), 1, 1e-5);
  return {value(image, "albedo.R"), value(image, "albedo.G"), value(image, "albedo.B")};
}

TEST(Albedo, OfGlassIsOneWhateverItsColour) {
  const std::array<double, 3> one{1, 1, 1};
  for (const bool thin : {false, true}) {
    scene::Dielectric glass;
    glass.transmittance = {0.5, 0.3, 0.1};
    glass.thin_walled = thin;
    EXPECT_EQ(own_albedo({"", glass}), one) << thin;
  }
  scene::Dielectric frosted;
  frosted.transmittance = {0.5, 0.3, 0.1};
  frosted.roughness = 0.4;
  EXPECT_EQ(own_albedo({"", frosted}), one);
}

TEST(Albedo, OfAMetalIsWhatItReflectsAlongItsNormalWhereverItIsSeenFrom) {
  for (const double roughness : {0.0, 0.3}) {
    scene::Conductor copper;
    copper.eta = {0.21, 0.92, 1.1};
    copper.k = {3.6, 2.6, 2.3};
    copper.roughness = roughness;
    scene::Principled brass;
    brass.base_color.factor = {0.9, 0.7, 0.3};
    brass.metallic.factor = 1;
    brass.roughness.factor = roughness;
    const std::array<double, 3> of_copper = own_albedo({"", copper}),
                                of_brass = own_albedo({"", brass});
    for (std::size_t c = 0; c < 3; ++c) {
      const double n = copper.eta[c], k = copper.k[c];
      const double along = ((n - 1) * (n - 1) + k * k) / ((n + 1) * (n + 1) + k * k);
      EXPECT_NEAR(of_copper[c], along, 1e-6) << roughness;
      EXPECT_NEAR(of_brass[c], brass.base_color.factor[c], 1e-6) << roughness;
      EXPECT_GT(std::abs(fresnel_conductor(aslant, n, k) - along), 1e-3)
          << "says nothing at this angle";
    }
  }
}

TEST(Albedo, OfALampIsItsLightClippedToOne) {
  EXPECT_EQ(own_albedo({"", scene::Emitter{{5, 0.25, 1.5}}}), (std::array<double, 3>{1, 0.25, 1}));
}

}  // namespace
}  // namespace tessera::render::proof
