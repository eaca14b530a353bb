#include <gtest/gtest.h>

#include <cstring>

#include "tests/render/support.hpp"
#include "worker/render/integrators/integrator.hpp"
#include "worker/render/sampler.hpp"

/// The exactness contract for each sampler and each integrator: however the film and its samples
/// are divided, the bits are the same.
namespace tessera::render::proof {
namespace {

constexpr int width = 21, height = 13;

Scene room() {
  SceneMaker maker;
  maker.add(maker.diffuse(0.7), scene::Box{{-1, -1, -1}, {1, 1, 1}});
  maker.add(maker.emitter(5), scene::Quad{{-0.3, 0.95, -0.3}, {0.6, 0, 0}, {0, 0, 0.6}});
  maker.add(maker.dielectric(1.5), scene::Sphere{{-0.4, -0.6, -0.3}, 0.35});
  maker.look({0, 0, 0.95}, {0, 0, -1}, 70);
  return maker.build();
}

/// (integrator, sampler)
class Division : public testing::TestWithParam<std::pair<std::string_view, std::string_view>> {
 protected:
  [[nodiscard]] static TaskRequest whole(std::int64_t first, std::int64_t count) {
    TaskRequest request;
    request.settings.width = width;
    request.settings.height = height;
    request.settings.bounces = 3;
    request.settings.light_samples = 3;
    request.settings.seed = 12;
    request.settings.integrator = GetParam().first;
    request.settings.sampler = GetParam().second;
    request.window = {0, 0, width, height};
    request.samples = {first, count};
    return request;
  }
  [[nodiscard]] static image::TileImage taken(const TaskRequest& request, int threads) {
    static const Scene scene = room();
    tbb::task_arena arena(threads);
    auto done = render_task(scene, request, arena);
    EXPECT_TRUE(done.has_value());
    return std::move(done->image);
  }
};

std::vector<std::pair<std::string_view, std::string_view>> ways() {
  std::vector<std::pair<std::string_view, std::string_view>> all;
  for (const std::string_view sampler : sampler_names()) all.emplace_back("path", sampler);
  for (const std::string_view integrator : integrator_names()) {
    if (integrator != "path") all.emplace_back(integrator, sampler_names().front());
  }
  all.emplace_back("hemisphere_lights", "mt19937");
  return all;
}
INSTANTIATE_TEST_SUITE_P(Names, Division, testing::ValuesIn(ways()), [](const auto& test) {
  return std::string(test.param.first) + "_" + std::string(test.param.second);
});

TEST_P(Division, OfTheFilmChangesNoBit) {
  const image::TileImage reference = taken(whole(0, 5), 1);
  for (const int side : {8, 11}) {
    const TileGrid grid(width, height, side);
    for (std::uint32_t tile = 0; tile < grid.count(); ++tile) {
      TaskRequest request = whole(0, 5);
      request.window = grid.tile(tile);
      const image::TileImage part = taken(request, 2);
      const auto columns = static_cast<std::size_t>(request.window.width);
      for (std::size_t c = 0; c < part.channels(); ++c) {
        for (int y = 0; y < request.window.height; ++y) {
          const auto from = reference.plane(c).subspan(
              static_cast<std::size_t>((request.window.y + y) * width + request.window.x), columns);
          const auto row = part.plane(c).subspan(static_cast<std::size_t>(y) * columns, columns);
          ASSERT_EQ(std::memcmp(row.data(), from.data(), row.size_bytes()), 0)
              << "tile side " << side << " channel " << c;
        }
      }
    }
  }
}

TEST_P(Division, OfTheSamplesChangesNoSample) {
  constexpr std::int64_t count = 6;
  const image::TileImage pass = taken(whole(2, count), 2);
  std::vector<double> sum(pass.pixels(), 0.0);
  for (std::int64_t k = 0; k < count; ++k) {
    const image::TileImage one = taken(whole(2 + k, 1), 1);
    for (std::size_t i = 0; i < sum.size(); ++i) {
      sum[i] += static_cast<double>(one.plane(image::G)[i]);
    }
  }
  for (std::size_t i = 0; i < sum.size(); ++i) {
    ASSERT_EQ(pass.plane(image::G)[i], static_cast<float>(sum[i] / count));
  }
}

}  // namespace
}  // namespace tessera::render::proof
