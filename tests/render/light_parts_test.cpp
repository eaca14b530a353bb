#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <optional>
#include <utility>

#include "common/base/error.hpp"
#include "common/scene/scene_file.hpp"
#include "tests/render/support.hpp"
#include "worker/scene/build.hpp"

/// The picture taken apart: by how often light scattered, by what the first surface did, by group.
namespace tessera::render::proof {
namespace {

using Names = std::vector<std::string>;

image::TileImage take(const Scene& scene, TaskRequest request, Names aovs) {
  request.settings.aovs = std::move(aovs);
  tbb::task_arena arena(2);
  std::optional<RenderedTask> done = render_task(scene, request, arena);
  return std::move(done.value().image);
}

double value(const image::TileImage& image, const std::string& channel, std::size_t pixel = 0) {
  const int index = image.layout->index_of(channel);
  EXPECT_GE(index, 0) << channel;
  return index < 0 ? 0 : image.plane(static_cast<std::size_t>(index))[pixel];
}

void expect_sum(const image::TileImage& image, const Names& parts, const std::string& what) {
  for (std::size_t pixel = 0; pixel < image.pixels(); ++pixel)
    for (const char* component : {"R", "G", "B"}) {
      double sum = 0;
      for (const std::string& part : parts) sum += value(image, part + '.' + component, pixel);
      const double whole = value(image, component, pixel);
      ASSERT_NEAR(sum, whole, 1e-5 * std::abs(whole) + 1e-12)
          << what << " pixel " << pixel << " " << component;
    }
}

class ReadyScenes : public testing::TestWithParam<const char*> {};

TEST_P(ReadyScenes, AreTheSumOfTheirParts) {
  scene::LoadedScene loaded =
      scene::load_scene(source_folder() / "scenes" / (std::string(GetParam()) + ".json"));
  // Every second thing that emits in a group of its own.
  bool odd = false;
  for (scene::Material& material : loaded.scene.materials)
    if (is_light(material) && (odd = !odd)) material.light_group = "odd";
  for (scene::PunctualLight& light : loaded.scene.lights)
    if ((odd = !odd)) light.light_group = "odd";
  if (loaded.scene.environment) loaded.scene.environment->light_group = "sky";
  TaskRequest request = request_of({.side = 24, .samples = 4, .bounces = 6}, 1);
  request.samples.first = 16;
  request.aovs = false;  // these travel with every pass
  const bool has_sky = loaded.scene.environment.has_value();
  const accel::Device device;
  const Scene scene = worker::build_scene(std::move(loaded.scene), device);
  Names groups{"light_default"};
  for (std::size_t i = 1; i < scene.light_groups.size(); ++i)
    groups.push_back("light_" + scene.light_groups[i]);
  ASSERT_GE(groups.size(), has_sky ? 2U : 1U);
  const Names depths{"direct", "indirect", "emission"};
  const Names lobes{"emission", "diffuse", "specular", "transmission"};
  Names all = groups;
  all.insert(all.end(), depths.begin(), depths.end());
  all.insert(all.end(), lobes.begin() + 1, lobes.end());
  for (const char* integrator : {"path", "cosine", "hemisphere_lights"}) {
    request.settings.integrator = integrator;
    const image::TileImage image = take(scene, request, all);
    expect_sum(image, depths, "depths");
    expect_sum(image, lobes, "lobes");
    expect_sum(image, groups, "groups");
    const image::TileImage plain = take(scene, request, {});
    for (std::size_t c = 0; c <= image::M2_B; ++c)
      for (std::size_t pixel = 0; pixel < image.pixels(); ++pixel)
        ASSERT_EQ(image.plane(c)[pixel], plain.plane(c)[pixel]) << c;
  }
}

INSTANTIATE_TEST_SUITE_P(LightParts, ReadyScenes,
                         testing::Values("cornell", "cornell-glass", "veach-mis", "material-lineup",
                                         "bokeh", "interior", "panorama", "caustics", "windmills",
                                         "perfume/perfume", "report/furnace", "report/report",
                                         "report/sky", "shadow-catcher"));

/// A wall before the camera, and a lamp behind the camera.
SceneMaker wall_and_lamp(std::uint32_t (SceneMaker::*wall)(double)) {
  SceneMaker maker;
  maker.add((maker.*wall)(0.5), scene::Quad{{-9, -9, 0}, {18, 0, 0}, {0, 18, 0}});
  maker.add(maker.emitter(1), scene::Quad{{9, -9, 8}, {-18, 0, 0}, {0, 18, 0}});
  maker.look({0, 0, 3}, {0, 0, 0}, 0.001, {0, 1, 0});
  return maker;
}

TEST(LightParts, StandWhereTheFirstSurfaceSentThem) {
  const Names all{"direct", "indirect", "emission", "diffuse", "specular", "transmission"};
  const TaskRequest request = request_of({.side = 1, .samples = 64, .bounces = 0}, 1);
  const auto seen = [&](const SceneMaker& maker) { return take(maker.build(), request, all); };

  const image::TileImage matte = seen(wall_and_lamp(&SceneMaker::diffuse));
  EXPECT_GT(value(matte, "R"), 0.1);
  EXPECT_NEAR(value(matte, "diffuse.R"), value(matte, "R"), 1e-6);
  EXPECT_NEAR(value(matte, "direct.R"), value(matte, "R"), 1e-6);
  EXPECT_EQ(value(matte, "specular.R"), 0);

  const image::TileImage mirrored = seen(wall_and_lamp(&SceneMaker::mirror));
  EXPECT_NEAR(value(mirrored, "specular.R"), 0.5, 1e-6);
  EXPECT_NEAR(value(mirrored, "direct.R"), 0.5, 1e-6);
  EXPECT_EQ(value(mirrored, "diffuse.R"), 0);
  EXPECT_EQ(value(mirrored, "emission.R"), 0);

  SceneMaker lamp;
  lamp.add(lamp.emitter(2), scene::Quad{{-9, -9, 0}, {18, 0, 0}, {0, 18, 0}});
  lamp.look({0, 0, 3}, {0, 0, 0}, 0.001, {0, 1, 0});
  EXPECT_NEAR(value(seen(lamp), "emission.R"), 2, 1e-6);
  EXPECT_EQ(value(seen(lamp), "direct.R"), 0);
}

/// Light samples, drawn directions and MIS share light among the lobes alike: else the parts would
/// depend on the integrator.
TEST(LightParts, OfGlossyPlasticDoNotDependOnTheIntegrator) {
  SceneMaker maker;
  scene::Material plastic;
  plastic.name = "plastic";
  scene::Principled coat;
  coat.roughness.factor = 0.4;
  plastic.surface = coat;
  maker.description.materials.push_back(plastic);
  maker.add(0, scene::Quad{{-9, -9, 0}, {18, 0, 0}, {0, 18, 0}});
  maker.add(maker.emitter(1), scene::Quad{{6, -3, 3}, {-6, 0, 2}, {0, 6, 0}});
  maker.look({-2, 0, 3}, {0, 0, 0}, 0.001, {0, 1, 0});
  const Scene scene = maker.build();
  const auto measured = [&](const char* integrator, const char* channel) {
    std::vector<double> means;
    for (std::uint64_t seed = 1; seed <= 24; ++seed) {
      TaskRequest request = request_of({.side = 4, .samples = 256, .bounces = 0}, seed);
      request.settings.integrator = integrator;
      const image::TileImage image = take(scene, request, {"diffuse", "specular"});
      double sum = 0;
      for (std::size_t i = 0; i < image.pixels(); ++i) sum += value(image, channel, i);
      means.push_back(sum / static_cast<double>(image.pixels()));
    }
    return estimate_of(means);
  };
  for (const char* channel : {"diffuse.R", "specular.R"}) {
    const Estimate by_path = measured("path", channel), by_cosine = measured("cosine", channel);
    const double error = std::hypot(by_path.error, by_cosine.error);
    EXPECT_GT(by_path.mean, 0.01) << channel;
    EXPECT_LT(error, 0.02 * by_path.mean) << channel << ": not precise enough to say anything";
    EXPECT_LT(std::abs(by_path.mean - by_cosine.mean), student_bound(23) * error) << channel;
  }
}

TEST(LightParts, OfAGroupThatIsNotThereAreRefusedWithTheNearest) {
  SceneMaker maker;
  maker.description.lights.push_back({.name = "lamp", .shape = {}, .light_group = "key"});
  const Scene scene = maker.build();
  TaskRequest request = request_of({.side = 1}, 1);
  request.settings.aovs = {"light_kye"};
  try {
    check_request(scene, request);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean \"light_key\"?"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace tessera::render::proof
