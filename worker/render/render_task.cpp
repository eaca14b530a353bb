#include "worker/render/render_task.hpp"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <vector>

#include "common/base/clock.hpp"
#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/base/thread_clock.hpp"
#include "common/job/aovs.hpp"
#include "common/scene/light_groups.hpp"
#include "worker/render/aov_sums.hpp"
#include "worker/render/camera.hpp"
#include "worker/render/filter.hpp"
#include "worker/render/float_mode.hpp"
#include "worker/render/integrators/integrator.hpp"
#include "worker/render/pixel.hpp"
#include "worker/render/sampler.hpp"

namespace tessera::render {
namespace {

const scene::Camera& camera_of(const Scene& scene, const std::string& name) {
  if (scene.cameras.empty()) throw Error(ErrorKind::bad_input, "the scene has no camera");
  if (name.empty()) return scene.cameras.front();
  std::vector<std::string_view> names;
  for (const scene::Camera& camera : scene.cameras) {
    if (camera.name == name) return camera;
    names.push_back(camera.name);
  }
  throw Error(ErrorKind::bad_input, unknown_name("camera", name, names));
}

/// All that is the same for every pixel of a task.
struct Plan {
  const Scene& scene;
  const TaskRequest& request;
  Camera camera;
  image::Layout layout;
  std::shared_ptr<const Filter> filter;
  SamplerKind sampler;
  Integrator integrator;
  std::uint64_t seed;
  LightClamp clamp;

  Plan(const Scene& on, const TaskRequest& asked)
      : scene(on),
        request(asked),
        camera(camera_of(on, asked.camera), asked.settings.width, asked.settings.height, on.origin,
               asked.settings.pixel_aspect),
        layout(image::layout_of(asked.settings.aovs)),
        filter(shared_filter(filter_kind(asked.settings.filter), asked.settings.filter_width)),
        sampler(sampler_kind(asked.settings.sampler)),
        integrator(render::integrator(asked.settings.integrator)),
        seed(frame_seed(asked.settings.seed, asked.frame)),
        clamp(LightClamp::of(asked.settings.clamp_direct, asked.settings.clamp_indirect)) {}
};

/// What a thread uses again from pixel to pixel.
struct Block {
  Trace trace;
  AovSums aovs;
  std::vector<SampleExtras> extras;   ///< samples_at_once, or none: nobody asks for them
  std::vector<CameraSample> samples;  ///< those that are under way
  PixelSets sets;                     ///< of the pixel
};

/// A sample of a pixel as it leaves the camera.
CameraSample leave_camera(const Plan& plan, PixelSets& sets, int x, int y, std::int64_t index) {
  const Sampler sampler(plan.sampler, sets, static_cast<std::uint64_t>(index));
  const Draw4 film = sampler.draw4(dim::film_set);
  const float time = plan.scene.moving ? sampler.draw4(dim::path_set)[dim::time] : 0.0F;
  const Vec2 offset = plan.filter->sample(film.pair(dim::film));
  CameraSample out{.sampler = sampler,
                   .ray = plan.camera.ray(x, y, offset, film.pair(dim::lens), time),
                   .record = {}};
  out.record.clamp = plan.clamp;
  return out;
}

/// Takes all samples of one pixel. Returns how many were rejected.
std::int64_t render_pixel(const Plan& plan, Block& block, int x, int y, PixelSums& sums) {
  constexpr auto at_once = static_cast<std::int64_t>(samples_at_once);
  std::int64_t rejected = 0;
  block.aovs.clear();
  block.sets.start(
      pixel_hash(plan.seed, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)));
  const SampleRange range = plan.request.samples;
  for (std::int64_t first = range.first; first < range.end(); first += at_once) {
    block.samples.clear();
    const std::int64_t end = std::min(first + at_once, range.end());
    for (std::int64_t index = first; index < end; ++index) {
      CameraSample& sample =
          block.samples.emplace_back(leave_camera(plan, block.sets, x, y, index));
      if (block.extras.empty()) continue;
      sample.record.extras = &block.extras[static_cast<std::size_t>(index - first)];
      sample.record.extras->clear();
    }
    plan.integrator(block.trace, block.samples);
    for (CameraSample& sample : block.samples) {
      SampleRecord& record = sample.record;
      if (!record.finite()) {
        record.clear();
        ++rejected;
      }
      sums.add(record);
      block.aovs.add(record);
    }
  }
  block.aovs.finish();
  return rejected;
}

/// What the threads count together.
struct Counts {
  std::atomic<std::int64_t> rays{0}, rejected{0}, cpu_nanoseconds{0}, pixels{0};
};

void render_block(const Plan& plan, const Rect& rect, image::TileImage& image, Counts& counts) {
  const FlushDenormals mode;
  const double began = thread_cpu_seconds();
  const RenderSettings& settings = plan.request.settings;
  Block block{.trace = {.scene = plan.scene,
                        .camera = plan.camera,
                        .bounces = settings.bounces,
                        .light_samples = settings.light_samples,
                        .aovs = plan.request.aovs,
                        .follow_specular = settings.aovs_follow_specular,
                        .closures = {}},
              .aovs = AovSums(*image.layout, plan.request.aovs, plan.scene.light_groups),
              .extras = {},
              .samples = {},
              .sets = {}};
  const AovSums::Wanted& wanted = block.aovs.wanted();
  block.trace.by_lobe = wanted.by_lobe;
  block.trace.coordinates = wanted.coordinates;
  block.trace.identities = wanted.identities;
  block.samples.reserve(samples_at_once);
  if (wanted.extras) block.extras.resize(samples_at_once);
  if (wanted.by_group) {
    for (SampleExtras& extras : block.extras)
      extras.by_group.resize(plan.scene.light_groups.size());
  }
  const std::size_t channels = image.channels();
  const std::size_t pixels = image.pixels();
  std::int64_t rejected = 0;
  double pixel_began = began;
  for (int y = rect.y; y < rect.y + rect.height; ++y) {
    for (int x = rect.x; x < rect.x + rect.width; ++x) {
      PixelSums sums;
      rejected += render_pixel(plan, block, x, y, sums);
      if (wanted.time) {
        const double now = thread_cpu_seconds();
        block.aovs.take_time(now - pixel_began);
        pixel_began = now;
      }
      const auto at = static_cast<std::size_t>(y - image.window.y) *
                          static_cast<std::size_t>(image.window.width) +
                      static_cast<std::size_t>(x - image.window.x);
      for (std::size_t c = 0; c < channels; ++c)
        image.values[c * pixels + at] =
            c <= image::M2_B ? sums.value(c) : block.aovs.value(c, plan.request.samples.count);
    }
  }
  counts.rays += block.trace.rays;
  counts.rejected += rejected;
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
