// The renderer called in process: a whole frame, pass by pass and tile by tile as a farm would take
// them, without farm. What the farm's cost is measured against. bench_direct SCENE WxH SAMPLES
// THREADS
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "common/job/job_spec.hpp"
#include "common/scene/scene_file.hpp"
#include "worker/render/render_task.hpp"
#include "worker/scene/build.hpp"

namespace {

int render(const char* file, int width, int height, std::int64_t samples, int threads) {
  using namespace tessera;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  scene::LoadedScene loaded = scene::load_scene(std::filesystem::path(file));
  JobSpec spec;
  spec.render = loaded.scene.render;
  spec.render.width = width;
  spec.render.height = height;
  spec.render.samples = samples;
  const JobPlan plan(spec);
  const accel::Device device;
  const render::Scene built =
      arena.execute([&] { return worker::build_scene(std::move(loaded.scene), device); });

  const auto started = std::chrono::steady_clock::now();
  std::int64_t rays = 0;
  for (std::uint32_t pass = 0; pass < plan.passes.count(); ++pass) {
    for (std::uint32_t tile = 0; tile < plan.grid.count(); ++tile) {
      render::TaskRequest request;
      request.settings = spec.render;
      request.frame = 1;
      request.window = plan.grid.tile(tile);
      request.samples = plan.passes.pass(pass);
      request.aovs = plan.passes.has_aovs(pass, spec.aov_samples);
      rays += render::render_task(built, request, arena)->stats.rays;
    }
  }
  const double took =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  std::printf("%.3f s, %.3f Mray/s\n", took, 1e-6 * static_cast<double>(rays) / took);
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  int width = 0, height = 0;
  if (count != 5 || std::sscanf(arguments[2], "%dx%d", &width, &height) != 2) {
    std::fprintf(stderr, "bench_direct SCENE WxH SAMPLES THREADS\n");
    return 2;
  }
  try {
    return render(arguments[1], width, height, std::atoll(arguments[3]), std::atoi(arguments[4]));
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "bench_direct: %s\n", problem.what());
    return 1;
  }
}
