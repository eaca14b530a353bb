#include "worker/render/render_task.hpp"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <atomic>
#include <vector>

#include "common/base/clock.hpp"
#include "common/base/error.hpp"
#include "common/base/thread_clock.hpp"
#include "common/job/aovs.hpp"
#include "common/scene/light_groups.hpp"
#include "worker/render/block.hpp"
#include "worker/render/float_mode.hpp"

namespace tessera::render {
namespace {

/// What the threads count together.
struct Counts {
  std::atomic<std::int64_t> rays{0}, rejected{0}, cpu_nanoseconds{0}, pixels{0};
};

void render_block(const Plan& plan, const Rect& rect, image::TileImage& image, Counts& counts) {
  const FlushDenormals mode;
  const double began = thread_cpu_seconds();
  Block block(plan, rect, image);
  block.render();
  counts.rays += block.rays();
  counts.rejected += block.rejected();
  counts.cpu_nanoseconds += static_cast<std::int64_t>((thread_cpu_seconds() - began) * 1e9);
}

/// Small enough that threads end together, large enough that a block costs far more than handing it
/// out.
int block_side(std::int64_t samples) { return samples >= 64 ? 4 : 8; }

image::TileImage empty_image(const Plan& plan) {
  const TaskRequest& request = plan.request;
  image::TileImage image;
  image.window = request.window;
  image.film_width = request.settings.width;
  image.film_height = request.settings.height;
  const auto count = static_cast<std::uint32_t>(request.samples.count);
  image.samples = {count, request.aovs ? count : 0};
  image.layout = plan.layout;
  image.values.resize(image.channels() * image.pixels());
  return image;
}

}  // namespace

SceneNeeds needs_of(const RenderSettings& settings) {
  const std::vector<AovUse> uses = aov_uses(settings.aovs);
  return {.coordinates = std::any_of(uses.begin(), uses.end(),
                                     [](const AovUse& use) { return use.aov == Aov::uv; })};
}

void check_request(const Scene& scene, const TaskRequest& request) {
  (void)camera_of(scene, request.camera);
  (void)filter_kind(request.settings.filter);
  (void)sampler_kind(request.settings.sampler);
  (void)integrator(request.settings.integrator);
  scene::check_light_groups(request.settings.aovs, scene.light_groups);
  const std::vector<AovUse> uses = aov_uses(request.settings.aovs);
  const auto carries = [](const AovUse& use) { return use.aov == Aov::shadow_catcher; };
  if (scene.has_catchers && std::none_of(uses.begin(), uses.end(), carries))
    throw Error(ErrorKind::bad_input,
                fmt::format("the scene has shadow catchers: expected \"{}\" among the AOVs, in "
                            "which their shadows travel",
                            shadow_catcher_aov),
                {.key = "render.aovs"});
  if (!scene.keeps.cover(needs_of(request.settings)))
    throw Error(ErrorKind::failed, "the scene was built without what the job's AOVs look at");
}

std::optional<RenderedTask> render_task(const Scene& scene, const TaskRequest& request,
                                        tbb::task_arena& arena, const TaskProgress& progress,
                                        const std::stop_token& stop) {
  const auto began = std::chrono::steady_clock::now();
  const Plan plan(scene, request);
  RenderedTask done{empty_image(plan), {}};
  Counts counts;
  const Rect& window = request.window;
  const int side = block_side(request.samples.count);
  const int columns = (window.width + side - 1) / side;
  const int rows = (window.height + side - 1) / side;
  const auto one = [&](int index) {
    if (stop.stop_requested()) return;
    const int x = index % columns * side, y = index / columns * side;
    const Rect block{window.x + x, window.y + y, std::min(side, window.width - x),
                     std::min(side, window.height - y)};
    render_block(plan, block, done.image, counts);
    const std::int64_t ready = counts.pixels += block.pixels();
    if (progress) progress(static_cast<double>(ready) / static_cast<double>(window.pixels()));
  };
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<int>(0, columns * rows, 1),
        [&](const tbb::blocked_range<int>& range) {
          for (int index = range.begin(); index < range.end(); ++index) one(index);
        },
        tbb::simple_partitioner{});
  });
  if (counts.pixels != window.pixels()) return std::nullopt;
  done.stats.samples = window.pixels() * request.samples.count;
  done.stats.rays = counts.rays;
  done.stats.rejected = counts.rejected;
  done.stats.seconds = seconds(std::chrono::steady_clock::now() - began);
  done.stats.cpu_seconds = static_cast<double>(counts.cpu_nanoseconds) * 1e-9;
  return done;
}

}  // namespace tessera::render
