#pragma once
#include <tbb/task_arena.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "common/image/tile.hpp"
#include "common/job/job_spec.hpp"
#include "common/job/pass_plan.hpp"
#include "common/job/tile_grid.hpp"
#include "worker/render/scene.hpp"

/// The renderer's door.
namespace tessera::render {

/// What to render: with the scene, all that decides the pixels' values.
struct TaskRequest {
  RenderSettings settings;  ///< the film's size, bounces, integrator, …; `samples` is not looked at
  std::string camera;       ///< one of the scene's; empty is its first
  std::int32_t frame = 0;  ///< frames of a job do not share their noise
  Rect window;             ///< within the film
  SampleRange samples;     ///< of each pixel
  bool aovs = false;       ///< bring the AOVs that do not travel with every pass, too
};

struct TaskStats {
  std::int64_t samples = 0;   ///< pixels times the range
  std::int64_t rays = 0;      ///< camera, scattered and shadow rays, whatever each goes through
  std::int64_t rejected = 0;  ///< samples that were NaN or Inf and count as black
  double seconds = 0;         ///< wall clock
  double cpu_seconds = 0;     ///< of the threads that rendered
};

struct RenderedTask {
  image::TileImage image;
  TaskStats stats;
};

/// Called now and then, from any of the threads, with the part that is done, 0…1.
using TaskProgress = std::function<void(double)>;

/// Renders one task with the threads of `arena`. A sample is a function of (scene, settings, frame,
/// pixel, index) alone, and a pixel's samples are summed in index order in double and rounded once,
/// so the result has the same bits for any window, arena and neighbour. M2 is the sum of squared
/// deviations from the mean, gathered about the range's first sample. A is 1 where the camera's ray
/// met a surface that is neither holdout nor shadow catcher, or an environment and the film is not
/// transparent, else 0; Z is the distance from the plane of the eye. Nothing if `stop` was asked
/// for. Throws Error{bad_input} for an unknown name. May be called from several threads at once.
std::optional<RenderedTask> render_task(const Scene& scene, const TaskRequest& request,
                                        tbb::task_arena& arena, const TaskProgress& progress = {},
                                        const std::stop_token& stop = {});

/// What a scene must keep for the AOVs of these settings.
SceneNeeds needs_of(const RenderSettings& settings);

/// Throws Error{bad_input} if a name in the settings, or the camera, is not known, or the scene has
/// shadow catchers and the settings do not ask for what they catch; Error{failed} if the scene does
/// not keep what the AOVs need.
void check_request(const Scene& scene, const TaskRequest& request);

}  // namespace tessera::render
