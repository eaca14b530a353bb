#include "worker/agent/path_renderer.hpp"

#include <fmt/format.h>
#include <gnu/libc-version.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <utility>

#include "common/base/build_info.hpp"
#include "common/base/error.hpp"
#include "common/scene/scene_file.hpp"
#include "worker/agent/moments.hpp"
#include "worker/agent/ticker.hpp"
#include "worker/render/render_task.hpp"
#include "worker/scene/build.hpp"

namespace tessera::agent {

namespace {
using Built = std::shared_ptr<const render::Scene>;

/// What a moving scene's other moments are built from.
struct Moving {
  Moving(const assets::Bundle& bundle, const SceneFiles& where, const scene::LoadedScene& first,
         const render::SceneNeeds& keep)
      : path(bundle.scene),
        files(where),
        duration(first.duration),
        made_up(first.made_up),
        needs(keep) {}
  std::string path;
  scene::BundleFiles files;
  double duration;  ///< seconds, after which all stands still
  scene::MadeUp made_up;
  render::SceneNeeds needs;
  Moments<render::Scene> moments{2};
};

class PathScene : public PreparedScene {
 public:
  bool serves(const RenderSettings& settings) const override {
    return first->keeps.cover(render::needs_of(settings));
  }

  Built first;                     ///< as it is at the time 0
  std::unique_ptr<Moving> moving;  ///< none: it is so at all times
};

const PathScene& path_scene(const PreparedScene& prepared) {
  return dynamic_cast<const PathScene&>(prepared);
}

class PathRenderer : public TaskRenderer {
 public:
  explicit PathRenderer(int threads)
      : limit_(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)),
        arena_(threads),
        threads_(threads),
        build_id_(
            digest_of(fmt::format("{}\n{}\n{}\nglibc {}\n{}\n", version(), build_commit(),
                                  build_flags(), gnu_get_libc_version(), device_.version()))) {}

  Digest build_id() const override { return build_id_; }
  int threads() const override { return threads_; }

  std::shared_ptr<const PreparedScene> prepare(const assets::Bundle& bundle,
                                               const SceneFiles& files,
                                               const RenderSettings& settings,
                                               const Fraction& progress,
                                               std::stop_token stop) override {
    const render::SceneNeeds needs = render::needs_of(settings);
    scene::LoadedScene loaded = scene::load_scene(scene::BundleFiles(files), bundle.scene);
    auto out = std::make_shared<PathScene>();
    if (loaded.duration > 0) out->moving = std::make_unique<Moving>(bundle, files, loaded, needs);
    out->first = build(std::move(loaded), needs, progress, stop);
    return out->first ? out : nullptr;
  }

  void check(const PreparedScene& scene, const JobSpec& spec) const override {
    render::check_request(*path_scene(scene).first, request_of(spec, {}));
  }

  std::optional<RenderedTile> render(const PreparedScene& scene, const JobSpec& spec,
                                     const RenderRequest& request, const Fraction& progress,
                                     std::stop_token stop) override {
    const PathScene& whole = path_scene(scene);
    const double time = moment_of(whole, time_of(spec, request.frame));
    // The part of the task that it takes to build the scene.
    const double before = is_there(whole, time) ? 0 : 0.5;
    const Built built = moment(whole, time, progress, before, stop);
    if (!built) return std::nullopt;
    std::optional<render::RenderedTask> done = render::render_task(
        *built, request_of(spec, request), arena_,
        [&](double fraction) { progress(before + (1 - before) * fraction); }, stop);
    if (!done) return std::nullopt;
    return RenderedTile{.image = std::move(done->image),
                        .samples = done->stats.samples,
                        .rays = done->stats.rays,
                        .rejected = done->stats.rejected,
                        .seconds = done->stats.seconds,
                        .cpu_seconds = done->stats.cpu_seconds};
  }

 private:
  /// Empty if `stop` was asked for.
  Built build(scene::LoadedScene loaded, const render::SceneNeeds& needs, const Fraction& progress,
              const std::stop_token& stop) {
    if (stop.stop_requested()) return nullptr;
    progress(0.5);
    const accel::Progress building = [&](double fraction) {
      progress(0.5 + 0.5 * fraction);
      return !stop.stop_requested();
    };
    try {
      return arena_.execute([&] {
        return std::make_shared<const render::Scene>(
            worker::build_scene(std::move(loaded.scene), device_, building, needs));
      });
    } catch (const Error&) {
      if (stop.stop_requested()) return nullptr;  // the build says that it was given up
      throw;
    }
  }

  /// The time that the scene is looked at: it stands still before its first moment and after its
  /// last.
  static double moment_of(const PathScene& scene, double time) {
    return scene.moving ? std::clamp(time, 0.0, scene.moving->duration) : 0;
  }
  static bool is_there(const PathScene& scene, double time) {
    return time == 0 || scene.moving->moments.has(time);
  }
  /// Empty if `stop` was asked for. Reports fractions up to `most` of what is not there.
  Built moment(const PathScene& scene, double time, const Fraction& progress, double most,
               const std::stop_token& stop) {
    if (time == 0) return scene.first;
    Moving& moving = *scene.moving;
    if (most == 0) return moving.moments.at(time, [&] { return load(moving, time, stop); });
    const Ticker ticker(progress, most);
    return moving.moments.at(time, [&] { return load(moving, time, stop); });
  }
  Built load(const Moving& moving, double time, const std::stop_token& stop) {
    // Those that waited for a build that was given up are mostly to be given up too.
    if (stop.stop_requested()) return nullptr;
    return build(
        scene::load_scene(moving.files, moving.path, {.time = time, .made_up = moving.made_up}),
        moving.needs, [](double) {}, stop);
  }

  static render::TaskRequest request_of(const JobSpec& spec, const RenderRequest& request) {
    return {.settings = spec.render,
            .camera = spec.camera,
            .frame = request.frame,
            .window = request.window,
            .samples = request.samples,
            .aovs = request.aovs};
  }

  tbb::global_control limit_;
  tbb::task_arena arena_;
  accel::Device device_;
  int threads_;
  Digest build_id_;
};
}  // namespace

std::unique_ptr<TaskRenderer> make_path_renderer(int threads) {
  return std::make_unique<PathRenderer>(threads);
}

}  // namespace tessera::agent
