// What the choice among lights is worth: small lamps over a town of blocks, one on every four
// square metres, chosen by what they do at the point against by their power alone. In one run, side
// by side: CPU time of a sample, and the error at equal time, relMSE·time, whose inverse ratio is
// how many times longer the other must render. bench_lights [--quick]
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <random>
#include <string_view>
#include <vector>

#include "common/base/thread_clock.hpp"
#include "worker/render/render_task.hpp"
#include "worker/scene/build.hpp"

namespace tessera::render {
namespace {

constexpr int side = 48;

scene::Scene town(int lamps) {
  std::mt19937 random(static_cast<std::uint32_t>(lamps));
  const auto number = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 8U) * 0x1p-24;
  };
  scene::Scene out;
  out.materials.push_back({"ground", scene::Diffuse{{0.5, 0.5, 0.5}}});
  constexpr std::uint32_t kinds = 16;
  for (std::uint32_t i = 0; i < kinds; ++i) {
    const double radiance = std::exp2(0.4 * i);
    out.materials.push_back({"lamp", scene::Emitter{{radiance, radiance, radiance}}});
  }
  const double reach = std::sqrt(4.0 * lamps), low = -0.5 * reach;
  out.shapes.push_back({"ground",
                        scene::Quad{{4 * low, 0, -4 * low}, {4 * reach, 0, 0}, {0, 0, -4 * reach}},
                        0,
                        {}});
  for (int i = 0; i < lamps; ++i) {
    const double x = number(low, -low), z = number(low, -low), y = number(0.4, 3);
    const std::uint32_t kind = 1 + static_cast<std::uint32_t>(random()) % kinds;
    if (i % 2 == 0) {
      out.shapes.push_back({"lamp", scene::Sphere{{x, y, z}, 0.05}, kind, {}});
    } else {
      out.shapes.push_back({"lamp", scene::Quad{{x, y, z}, {0.1, 0, 0}, {0, 0, 0.1}}, kind, {}});
    }
    if (i % 4 != 0) continue;
    const double bx = number(low, -low), bz = number(low, -low), size = number(0.2, 1);
    out.shapes.push_back(
        {"block", scene::Box{{bx, 0, bz}, {bx + size, 2 * size, bz + size}}, 0, {}});
  }
  out.cameras.push_back(
      {.name = "camera", .eye = {0, 12, 12}, .target = {0, 0, 0}, .fov_y_degrees = 35});
  return out;
}

struct Picture {
  std::vector<double> pixels;
  double seconds = 0;
};

Picture taken(const Scene& scene, std::int64_t samples, std::uint64_t seed) {
  tbb::task_arena arena(1);
  TaskRequest request;
  request.settings.width = side;
  request.settings.height = side;
  request.settings.bounces = 1;
  request.settings.filter = "box";
  request.settings.seed = seed;
  request.window = {0, 0, side, side};
  request.samples = {0, samples};
  const RenderedTask done = render_task(scene, request, arena).value();
  const auto plane = done.image.plane(image::G);
  return {{plane.begin(), plane.end()}, done.stats.cpu_seconds};
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// relMSE, a hundredth of the mean added to what divides.
double error_of(const Picture& picture, const Picture& truth) {
  const double floor = 0.01 * mean_of(truth.pixels);
  double sum = 0;
  for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
    const double off = picture.pixels[i] - truth.pixels[i];
    sum += off * off / (truth.pixels[i] * truth.pixels[i] + floor * floor);
  }
  return sum / static_cast<double>(truth.pixels.size());
}

struct Cost {
  double error = 0, nanoseconds = 0;
  [[nodiscard]] double at_equal_time() const { return error * nanoseconds; }
};

Cost measured(const Scene& scene, const Picture& truth, std::int64_t samples, int seeds) {
  Cost cost;
  for (int seed = 1; seed <= seeds; ++seed) {
    const Picture picture = taken(scene, samples, static_cast<std::uint64_t>(seed));
    cost.error += error_of(picture, truth) / seeds;
    cost.nanoseconds +=
        1e9 * picture.seconds / (seeds * static_cast<double>(samples) * side * side);
  }
  return cost;
}

void compare(int lamps, bool quick) {
  const accel::Device device;
  Scene scene = worker::build_scene(town(lamps), device);
  const std::vector<Light> lights = scene.lights.lights();
  const double started = thread_cpu_seconds();
  scene.lights = LightTable(lights);
  const double built = thread_cpu_seconds() - started;

  const Picture truth = taken(scene, quick ? 2048 : 16384, 1000);
  const std::int64_t samples = 64;
  const int seeds = quick ? 4 : 16;
  const Cost tree = measured(scene, truth, samples, seeds);
  scene.lights = LightTable(lights, LightTable::Choice::by_power);
  const Cost power = measured(scene, truth, samples, seeds);
  const double ratio = power.at_equal_time() / tree.at_equal_time();
  std::printf("%7d %10.4f s %10.0f %10.0f %12.5f %12.5f %11.1f %11.2f\n", lamps, built,
              tree.nanoseconds, power.nanoseconds, tree.error, power.error, ratio,
              std::sqrt(ratio));
  std::fflush(stdout);
}

}  // namespace
}  // namespace tessera::render

int main(int count, char** arguments) {
  try {
    const bool quick = count > 1 && std::string_view(arguments[1]) == "--quick";
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    std::printf("%7s %12s %10s %10s %12s %12s %11s %11s\n", "lights", "tree built", "ns/sample",
                "by power", "relMSE", "by power", "equal time", "its root");
    for (const int lamps : {10, 30, 100, 1000, 10'000, 100'000})
      tessera::render::compare(lamps, quick);
    return 0;
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "bench_lights: %s\n", problem.what());
    return 1;
  }
}
