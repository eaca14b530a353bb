#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/support.hpp"

/// What theory says of the founding report's estimator, and of those that replaced it. Samples are
/// independent here (pcg), so that a pixel's M2 measures the estimator's own variance.
namespace tessera::render::proof {
namespace {

Take plain(std::string integrator, std::int64_t samples, int bounces, int light_samples = 1) {
  Take take{8, samples, bounces, light_samples};
  take.integrator = std::move(integrator);
  take.sampler = "pcg";
  return take;
}

/// The variance of one sample, from M2, by seeds.
Estimate variance(const Scene& scene, const Take& take, int replicates = 24) {
  std::vector<double> values;
  for (int k = 0; k < replicates; ++k) {
    const RenderedTask done = render(scene, take, 500 + static_cast<std::uint64_t>(k));
    double sum = 0;
    for (const float m2 : done.image.plane(image::M2_R)) sum += m2;
    values.push_back(sum / static_cast<double>(done.image.pixels()) /
                     static_cast<double>(take.samples - 1));
  }
  return estimate_of(values);
}

Scene floor_under_the_sky(double albedo) {
  SceneMaker maker;
  maker.add(maker.diffuse(albedo), scene::Quad{{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}});
  maker.environment(1).look({0.3, 0.1, 2}, {0, 0, 0});
  return maker.build();
}

TEST(Report, UniformDirectionsHaveVarianceOfAThirdOfAlbedoSquared) {
  for (const double albedo : {0.3, 0.8}) {
    const Scene scene = floor_under_the_sky(albedo);
    expect_mean(measure(scene, plain("hemisphere", 256, 0)), albedo);
    expect_mean(variance(scene, plain("hemisphere", 256, 0)), albedo * albedo / 3, 0.005);
  }
}

TEST(Report, DirectionsByTheCosineHaveNoVarianceThere) {
  for (const char* integrator : {"cosine", "path", "hemisphere_lights"}) {
    // The last one's light samples of an environment are drawn by the cosine.
    const Scene scene = floor_under_the_sky(0.8);
    const RenderedTask done = render(scene, plain(integrator, 256, 0), 1);
    for (const float value : done.image.plane(image::R)) EXPECT_NEAR(value, 0.8, 1e-6);
    for (const float m2 : done.image.plane(image::M2_R)) EXPECT_LT(m2, 1e-9) << integrator;
  }
}

/// Second moment of what the n-th scattering brings in a closed room whose walls emit 1: a sample's
/// radiance with n scatterings less that of the same sample with one less.
Estimate second_moment(const Scene& scene, const std::string& integrator, int scatterings) {
  constexpr int replicates = 36;
  std::vector<double> values;
  for (int k = 0; k < replicates; ++k) {
    Take take = plain(integrator, 1, scatterings - 1);
    take.side = 64;
    const auto seed = static_cast<std::uint64_t>(k);
    const RenderedTask more = render(scene, take, seed);
    take.bounces = scatterings - 2;
    const bool any = scatterings > 1;
    const RenderedTask less = any ? render(scene, take, seed) : RenderedTask{};
    double sum = 0;
    for (std::size_t i = 0; i < more.image.pixels(); ++i) {
      const double before = any ? static_cast<double>(less.image.plane(image::R)[i]) : 1.0;
      const double brought = static_cast<double>(more.image.plane(image::R)[i]) - before;
      sum += brought * brought;
    }
    values.push_back(sum / static_cast<double>(more.image.pixels()));
  }
  return estimate_of(values);
}

TEST(Report, TheSecondMomentGrowsByFourThirdsOfAlbedoSquaredABounce) {
  for (const double albedo : {0.8, 0.92}) {
    SceneMaker maker;
    maker.add(maker.emitter(1, true), scene::Box{{-1, -1, -1}, {1, 1, 1}});
    maker.look({0.1, 0.2, 0.3}, {0.5, 0.4, -1}, 60);
    const Scene scene = maker.build(albedo);
    std::vector<double> moments;
    for (int n = 1; n <= 6; ++n) {
      const Estimate moment = second_moment(scene, "hemisphere", n);
      expect_mean(moment, std::pow(4 * albedo * albedo / 3, n), 0.02);
      moments.push_back(moment.mean);
    }
    // Above √3/2 the variance of a path without end is infinite; below, the series converges.
    if (albedo > std::sqrt(3) / 2) {
      EXPECT_GT(moments.back(), 1.5 * moments.front());
    } else {
      EXPECT_LT(moments.back(), moments.front());
    }
    // By the cosine each bounce brings ρⁿ exactly (roulette ends no path that carries so much).
    EXPECT_NEAR(second_moment(scene, "cosine", 1).mean, albedo * albedo, 1e-5);
  }
}

/// A lamp over a floor; a block that shadows some of it.
SceneMaker lamp_over_a_floor() {
  SceneMaker maker;
  maker.add(maker.diffuse(0.7), scene::Quad{{-4, -4, 0}, {8, 0, 0}, {0, 8, 0}});
  maker.add(maker.emitter(5), scene::Quad{{-0.5, -0.5, 1.5}, {0, 1, 0}, {1, 0, 0}});
  maker.add(maker.diffuse(0.5), scene::Box{{0.2, -0.5, 0.4}, {0.8, 0.3, 0.6}});
  return maker;
}

class LightSamples : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Names, LightSamples, testing::Values("hemisphere_lights", "path"),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(LightSamples, ChangeTheNoiseAndNotTheMean) {
  SceneMaker maker = lamp_over_a_floor();
  maker.look({0, -3, 1.2}, {0, 0, 0.3}, 50);
  const Scene scene = maker.build();
  const Estimate one = measure(scene, plain(GetParam(), 64, 2, 1));
  const double noise = variance(scene, plain(GetParam(), 64, 2, 1)).mean;
  double before = noise;
  for (const int count : {4, 16}) {
    const Estimate more = measure(scene, plain(GetParam(), 64, 2, count));
    EXPECT_LT(more.error, 0.01 * more.mean);
    EXPECT_NEAR(more.mean, one.mean, student_bound(23) * std::hypot(one.error, more.error));
    const double less = variance(scene, plain(GetParam(), 64, 2, count)).mean;
    EXPECT_LT(less, before);
    before = less;
  }
}

TEST(Report, TheVarianceOfDirectLightFallsAsOneOverTheLightSamples) {
  // One point in half shadow, light samples alone: each of N has the same variance.
  SceneMaker maker = lamp_over_a_floor();
  maker.look({0.3, -2, 1}, {0.1, 0, 0});
  const Scene scene = maker.build();
  const Estimate one = variance(scene, plain("hemisphere_lights", 256, 0, 1));
  for (const int count : {4, 16}) {
    const Estimate more = variance(scene, plain("hemisphere_lights", 256, 0, count));
    EXPECT_LT(more.error, 0.02 * more.mean);
    EXPECT_NEAR(count * more.mean, one.mean,
                student_bound(23) * std::hypot(one.error, count * more.error));
  }
}

TEST(Report, WhatTakesNoLightSamplesDoesNotHeedTheirNumber) {
  SceneMaker maker = lamp_over_a_floor();
  maker.look({0, -3, 1.2}, {0, 0, 0.3}, 50);
  const Scene scene = maker.build();
  for (const char* integrator : {"hemisphere", "cosine"}) {
    const RenderedTask one = render(scene, plain(integrator, 8, 2, 1), 1);
    const RenderedTask many = render(scene, plain(integrator, 8, 2, 16), 1);
    EXPECT_EQ(one.image.values, many.image.values) << integrator;
    EXPECT_EQ(one.stats.rays, many.stats.rays) << integrator;
  }
}

TEST(Report, ItsPathsEndByDepthAlone) {
  // A closed room of little albedo: without roulette each path has all its rays.
  SceneMaker maker;
  maker.add(maker.diffuse(0.2), scene::Box{{-1, -1, -1}, {1, 1, 1}});
  maker.look({0.1, 0.2, 0.3}, {0.5, 0.4, -1}, 60);
  const Scene scene = maker.build();
  const RenderedTask report = render(scene, plain("hemisphere", 16, 6), 1);
  EXPECT_EQ(report.stats.rays, 8 * report.stats.samples);
  const RenderedTask cosine = render(scene, plain("cosine", 16, 6), 1);
  EXPECT_LT(cosine.stats.rays, 5 * cosine.stats.samples);
}

TEST(Report, CountsItsShadowRays) {
  // A floor that sees a lamp and nothing else: camera, N light samples, one scattered ray.
  SceneMaker maker;
  maker.add(maker.diffuse(0.7), scene::Quad{{-4, -4, 0}, {8, 0, 0}, {0, 8, 0}});
  maker.add(maker.emitter(5), scene::Quad{{-0.5, -0.5, 1.5}, {0, 1, 0}, {1, 0, 0}});
  maker.look({0.3, -2, 1}, {0.1, 0, 0});
  const Scene scene = maker.build();
  for (const int count : {1, 4}) {
    const RenderedTask done = render(scene, plain("hemisphere_lights", 16, 0, count), 1);
    EXPECT_EQ(done.stats.rays, (2 + count) * done.stats.samples);
  }
}

}  // namespace
}  // namespace tessera::render::proof
