#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <thread>

#include "common/base/error.hpp"
#include "tests/render/support.hpp"
#include "worker/render/integrators/integrator.hpp"

/// The exactness contract: a sample is a function of (scene, frame, pixel, index, seed) alone.
namespace tessera::render::proof {
namespace {

constexpr int width = 45, height = 31;

Scene room() {
  SceneMaker maker;
  maker.add(maker.diffuse(0.7), scene::Box{{-1, -1, -1}, {1, 1, 1}});
  maker.add(maker.emitter(5), scene::Quad{{-0.3, 0.99, -0.3}, {0.6, 0, 0}, {0, 0, 0.6}});
  maker.add(maker.dielectric(1.5), scene::Sphere{{-0.4, -0.6, -0.3}, 0.35});
  maker.add(maker.diffuse(0.4), ball(3, true), translate(0.4, -0.6, 0.1) * scale(0.3, 0.3, 0.3));
  maker.look({0, 0, 0.95}, {0, 0, -1}, 70);
  return maker.build();
}

TaskRequest whole(std::int64_t first, std::int64_t count) {
  TaskRequest request;
  request.settings.width = width;
  request.settings.height = height;
  request.settings.light_samples = 2;
  request.settings.seed = 77;
  request.window = {0, 0, width, height};
  request.samples = {first, count};
  request.aovs = true;
  return request;
}

image::TileImage taken(const Scene& scene, const TaskRequest& request, int threads) {
  tbb::task_arena arena(threads);
  auto done = render_task(scene, request, arena);
  EXPECT_TRUE(done.has_value());
  return std::move(done->image);
}

bool same_bits(std::span<const float> a, std::span<const float> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

TEST(Bits, DoNotDependOnTheNumberOfThreads) {
  const tbb::global_control four(tbb::global_control::max_allowed_parallelism, 4);
  const Scene scene = room();
  const image::TileImage one = taken(scene, whole(0, 16), 1);
  EXPECT_TRUE(same_bits(taken(scene, whole(0, 16), 2).values, one.values));
  EXPECT_TRUE(same_bits(taken(scene, whole(0, 16), 4).values, one.values));
}

TEST(Bits, DoNotDependOnHowTheFilmIsCut) {
  const Scene scene = room();
  const image::TileImage reference = taken(scene, whole(4, 12), 2);
  for (const int side : {7, 16, 23}) {
    const TileGrid grid(width, height, side);
    for (std::uint32_t tile = 0; tile < grid.count(); ++tile) {
      TaskRequest request = whole(4, 12);
      request.window = grid.tile(tile);
      const image::TileImage part = taken(scene, request, 2);
      for (std::size_t c = 0; c < part.channels(); ++c) {
        for (int y = 0; y < request.window.height; ++y) {
          const auto from =
              static_cast<std::size_t>((request.window.y + y) * width + request.window.x);
          const auto row = static_cast<std::size_t>(request.window.width);
          ASSERT_TRUE(same_bits(part.plane(c).subspan(static_cast<std::size_t>(y) * row, row),
                                reference.plane(c).subspan(from, row)))
              << "tile side " << side << " channel " << c;
        }
      }
    }
  }
}

TEST(Bits, APassIsTheSumOfItsSamplesRoundedOnce) {
  const Scene scene = room();
  // More than go side by side, and not a multiple of them.
  constexpr auto count = static_cast<std::int64_t>(samples_at_once) + 5;
  const image::TileImage pass = taken(scene, whole(3, count), 2);
  std::vector<image::TileImage> singles;
  for (std::int64_t k = 0; k < count; ++k) singles.push_back(taken(scene, whole(3 + k, 1), 2));
  for (std::size_t i = 0; i < pass.pixels(); ++i) {
    for (const std::size_t c : {image::R, image::G, image::B, image::A}) {
      double sum = 0;
      for (const auto& single : singles) sum += single.plane(c)[i];
      ASSERT_EQ(pass.plane(c)[i], static_cast<float>(sum / count));
    }
    for (std::size_t c = 0; c < 3; ++c) {
      long double mean = 0, m2 = 0;
      for (const auto& single : singles) mean += single.plane(c)[i];
      mean /= count;
      for (const auto& single : singles) {
        const long double off = single.plane(c)[i] - mean;
        m2 += off * off;
        ASSERT_EQ(single.plane(image::M2_R + c)[i], 0);
      }
      ASSERT_NEAR(pass.plane(image::M2_R + c)[i], m2, 1e-6 * static_cast<double>(m2) + 1e-30);
    }
    float nearest = image::nothing_hit_z;
    for (const auto& single : singles) nearest = std::min(nearest, single.plane(image::Z)[i]);
    ASSERT_EQ(pass.plane(image::Z)[i], nearest);
  }
}

TEST(Bits, WhatStandsBesideThePictureIsEachSamplesOwn) {
  // Samples that go side by side share nothing of what they saw.
  const Scene scene = room();
  constexpr auto count = static_cast<std::int64_t>(samples_at_once) + 5;
  const auto with = [](TaskRequest request) {
    request.settings.aovs = {"albedo",   "N",       "P",        "direct",
                             "indirect", "diffuse", "specular", "transmission"};
    return request;
  };
  const image::TileImage pass = taken(scene, with(whole(0, count)), 2);
  std::vector<image::TileImage> singles;
  for (std::int64_t k = 0; k < count; ++k) singles.push_back(taken(scene, with(whole(k, 1)), 2));
  ASSERT_EQ(pass.channels(), image::M2_B + 1 + 8 * 3U);
  for (std::size_t c = image::M2_B + 1; c < pass.channels(); ++c) {
    bool seen = false;
    for (std::size_t i = 0; i < pass.pixels(); ++i) {
      double sum = 0;
      for (const auto& single : singles) sum += single.plane(c)[i];
      ASSERT_EQ(pass.plane(c)[i], static_cast<float>(sum / count)) << "channel " << c;
      seen = seen || sum != 0;
    }
    EXPECT_TRUE(seen) << "channel " << c;
  }
}

TEST(Bits, APassWithoutAovsHasTheSameBeauty) {
  const Scene scene = room();
  TaskRequest request = whole(0, 4);
  const image::TileImage with = taken(scene, request, 2);
  request.aovs = false;
  const image::TileImage without = taken(scene, request, 2);
  EXPECT_FALSE(without.has_aovs());
  EXPECT_EQ(without.samples[1], 0U);
  ASSERT_LT(without.values.size(), with.values.size());
  EXPECT_TRUE(same_bits(without.values, std::span(with.values).first(without.values.size())));
}

TEST(Bits, AnotherSeedOrFrameGivesOtherNoise) {
  const Scene scene = room();
  const image::TileImage reference = taken(scene, whole(0, 4), 2);
  TaskRequest other_seed = whole(0, 4), other_frame = whole(0, 4);
  other_seed.settings.seed = 78;
  other_frame.frame = 1;
  for (const TaskRequest& request : {other_seed, other_frame}) {
    const image::TileImage other = taken(scene, request, 2);
    std::size_t equal = 0;
    for (std::size_t i = 0; i < other.pixels(); ++i) {
      if (other.plane(image::R)[i] == reference.plane(image::R)[i]) ++equal;
    }
    EXPECT_LT(equal, other.pixels() / 10);
  }
}

TEST(Bits, TwoScenesBuiltFromOneDescriptionRenderAlike) {
  EXPECT_TRUE(
      same_bits(taken(room(), whole(0, 4), 1).values, taken(room(), whole(0, 4), 2).values));
}

TEST(Task, TasksRunAtOnceInOneArena) {
  const Scene scene = room();
  const image::TileImage reference = taken(scene, whole(0, 8), 2);
  tbb::task_arena arena(2);
  std::vector<std::optional<RenderedTask>> results(3);
  {
    std::vector<std::jthread> callers;
    for (auto& result : results) {
      callers.emplace_back([&] { result = render_task(scene, whole(0, 8), arena); });
    }
  }
  for (const auto& result : results) {
    ASSERT_TRUE(result.has_value());
    EXPECT_TRUE(same_bits(result->image.values, reference.values));
  }
}

TEST(Task, CountsWhatItDid) {
  const Scene scene = room();
  tbb::task_arena arena(2);
  std::atomic<double> last{0};
  const auto done = render_task(scene, whole(0, 4), arena, [&](double part) {
    EXPECT_GT(part, 0);
    EXPECT_LE(part, 1);
    double before = last.load();
    while (before < part && !last.compare_exchange_weak(before, part)) {
    }
  });
  ASSERT_TRUE(done.has_value());
  EXPECT_EQ(done->stats.samples, std::int64_t{width} * height * 4);
  EXPECT_GT(done->stats.rays, 2 * done->stats.samples);
  EXPECT_EQ(done->stats.rejected, 0);
  EXPECT_GT(done->stats.seconds, 0);
  EXPECT_GT(done->stats.cpu_seconds, 0);
  EXPECT_EQ(last, 1.0);
}

TEST(Task, StopsWhenAsked) {
  const Scene scene = room();
  tbb::task_arena arena(2);
  std::stop_source stop;
  TaskRequest request = whole(0, 512);
  const auto done = render_task(
      scene, request, arena, [&](double) { stop.request_stop(); }, stop.get_token());
  EXPECT_FALSE(done.has_value());
}

TEST(Task, UnknownNamesAreErrorsThatNameTheNearest) {
  const Scene scene = room();
  const auto message_for = [&](auto&& change) -> std::string {
    TaskRequest request = whole(0, 1);
    change(request);
    try {
      check_request(scene, request);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::bad_input);
      return error.what();
    }
    return {};
  };
  EXPECT_NE(message_for([](TaskRequest& r) { r.settings.integrator = "pth"; }).find("path"),
            std::string::npos);
  EXPECT_NE(message_for([](TaskRequest& r) { r.settings.filter = "boks"; }).find("box"),
            std::string::npos);
  EXPECT_NE(
      message_for([](TaskRequest& r) { r.settings.sampler = "sobol_oven"; }).find("sobol_owen"),
      std::string::npos);
  EXPECT_NE(message_for([](TaskRequest& r) { r.camera = "mian"; }).find("main"), std::string::npos);
}

TEST(Task, ASampleThatIsNoNumberCountsAsBlack) {
  SceneMaker maker;
  maker.add(maker.emitter(1), scene::Quad{{-10, -10, 0}, {20, 0, 0}, {0, 20, 0}});
  maker.look({0, 0, 5}, {0, 0, 0}, 30);
  Scene scene = maker.build();
  for (Instruction& step : scene.materials[0].program) {
    step.radiance = gray(std::numeric_limits<float>::infinity());
  }
  tbb::task_arena arena(2);
  TaskRequest request = whole(0, 4);
  const auto done = render_task(scene, request, arena);
  ASSERT_TRUE(done.has_value());
  EXPECT_EQ(done->stats.rejected, done->stats.samples);
  EXPECT_EQ(done->image.samples[0], 4U);
  for (const float value : done->image.values) ASSERT_TRUE(std::isfinite(value));
  for (const float value : done->image.plane(image::R)) ASSERT_EQ(value, 0);
}

TEST(Task, AlphaIsOneWhereSomethingIsSeen) {
  SceneMaker maker;
  maker.add(maker.diffuse(0.5), scene::Sphere{{0, 0, 0}, 1});
  maker.look({0, 0, 5}, {0, 0, 0}, 60);
  const RenderedTask open = render(maker.build(), {16, 4}, 1);
  EXPECT_EQ(open.image.plane(image::A)[0], 0);
  EXPECT_EQ(open.image.plane(image::Z)[0], image::nothing_hit_z);
  EXPECT_EQ(open.image.plane(image::A)[8 * 16 + 8], 1);
  EXPECT_NEAR(open.image.plane(image::Z)[8 * 16 + 8], 4, 0.1);
  EXPECT_NEAR(open.image.plane(image::N_Z)[8 * 16 + 8], 1, 0.1);
  EXPECT_NEAR(open.image.plane(image::albedo_R)[8 * 16 + 8], 0.5, 1e-6);
  maker.environment(0);
  const RenderedTask sky = render(maker.build(), {16, 4}, 1);
  EXPECT_EQ(sky.image.plane(image::A)[0], 1);
}

}  // namespace
}  // namespace tessera::render::proof
