#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <array>
#include <optional>
#include <string>

#include "tests/render/support.hpp"

/// How far two renders by two seeds lie apart, and how far their variances say that they do.
namespace tessera::render::proof {
namespace {

constexpr int side = 24;
constexpr std::int64_t samples = 16;

image::TileImage rendered(const Scene& scene, const std::string& sampler, std::uint64_t seed) {
  const Take take{.side = side, .samples = samples, .bounces = 4, .sampler = sampler};
  return std::move(render(scene, take, seed).image);
}

/// Over the film, the mean of (a − b)² and of both variances of the pixels' means, as a picture's
/// file has them: M2/(n(n − 1)).
struct Apart {
  double squares = 0, variances = 0;
};
Apart apart(const image::TileImage& a, const image::TileImage& b, std::size_t channel) {
  constexpr auto moment = image::M2_R - image::R;
  constexpr double n = samples;
  Apart out;
  for (std::size_t pixel = 0; pixel < a.pixels(); ++pixel) {
    const double difference = double{a.plane(channel)[pixel]} - double{b.plane(channel)[pixel]};
    const double moments =
        double{a.plane(channel + moment)[pixel]} + double{b.plane(channel + moment)[pixel]};
    out.squares += difference * difference / static_cast<double>(a.pixels());
    out.variances += moments / (n * (n - 1)) / static_cast<double>(a.pixels());
  }
  return out;
}

struct Measured {
  Estimate variances;
  Estimate excess;  ///< of the squares over the variances
};
std::array<Measured, 3> measured(const Scene& scene, const std::string& sampler) {
  std::array<std::vector<double>, 3> variances, excess;
  for (std::uint64_t pair = 0; pair < 24; ++pair) {
    const image::TileImage a = rendered(scene, sampler, 2 * pair),
                           b = rendered(scene, sampler, 2 * pair + 1);
    for (std::size_t c = 0; c < 3; ++c) {
      const Apart found = apart(a, b, image::R + c);
      variances[c].push_back(found.variances);
      excess[c].push_back(found.squares - found.variances);
    }
  }
  std::array<Measured, 3> out;
  for (std::size_t c = 0; c < 3; ++c) out[c] = {estimate_of(variances[c]), estimate_of(excess[c])};
  return out;
}

/// A room whose lamp is behind the camera, with a ball that shines dully and a box: its noise is
/// spread over all pixels.
Scene room() {
  SceneMaker maker;
  scene::Principled dull;
  dull.roughness.factor = 0.5;
  maker.description.materials = {{"m0", scene::Diffuse{{0.7, 0.6, 0.5}}}, {"m1", dull}};
  maker.add(0, scene::Box{{-2, -1, -2}, {2, 2, 4}});
  maker.add(1, scene::Sphere{{-0.6, -0.4, -0.5}, 0.6});
  maker.add(0, scene::Box{{0.3, -1, -0.8}, {1, 0, -0.1}});
  maker.add(maker.emitter(6), scene::Quad{{-1, 1.9, 2}, {2, 0, 0}, {0, 0, 1.5}});
  maker.look({0, 0.2, 3}, {0, -0.2, 0}, 45);
  return maker.build();
}

/// Samples that know nothing of each other: the variance is what it says.
TEST(TwoSeeds, OfIndependentSamplesDifferByBothVariancesTogether) {
  const Scene scene = room();
  for (const char* sampler : {"independent", "pcg"})
    for (const Measured& channel : measured(scene, sampler)) {
      EXPECT_LT(channel.excess.error, 0.03 * channel.variances.mean) << sampler << ": says nothing";
      EXPECT_NEAR(channel.excess.mean, 0, student_bound(23) * channel.excess.error) << sampler;
    }
}

/// Samples that are spread evenly: the variance knows nothing of that, and says too much.
TEST(TwoSeeds, OfEvenSamplesDifferByLessThanBothVariancesTogether) {
  for (const Measured& channel : measured(room(), "sobol_owen")) {
    EXPECT_LT(channel.excess.error, 0.03 * channel.variances.mean) << "says nothing";
    EXPECT_LT(channel.excess.mean, -student_bound(23) * channel.excess.error);
  }
}

}  // namespace
}  // namespace tessera::render::proof
