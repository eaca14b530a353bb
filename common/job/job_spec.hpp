#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/digest.hpp"
#include "common/job/frames.hpp"
#include "common/job/matte.hpp"
#include "common/job/pass_plan.hpp"
#include "common/job/task.hpp"
#include "common/job/tile_grid.hpp"

namespace tessera {

/// How the samples of a frame are taken: with the scene, all that decides their values.
struct RenderSettings {
  int width = 0;  ///< film, pixels
  int height = 0;
  std::int64_t samples = 64;  ///< of each pixel
  int bounces = 12;           ///< 0 is emission and direct light; counted as Cycles does
  std::string integrator = "path";
  std::string sampler = "sobol_owen";
  std::string filter = "blackman_harris";
  double filter_width = 0;  ///< pixels from edge to edge; 0 is the filter's own default
  int light_samples = 1;    ///< light samples at each hit
  std::uint64_t seed = 0;
  double pixel_aspect = 1;   ///< width of a pixel over its height, in what the camera sees
  std::optional<Rect> crop;  ///< pixels of the film that are rendered; nothing: all
  /// The most that one contribution to a sample may have, as the mean of its R, G and B: of light
  /// that has met one surface, and of light that has met several. 0: no limit, and no bias.
  double clamp_direct = 0, clamp_indirect = 0;
  /// Outputs beside the picture, by name (aovs.hpp); none: albedo, N, Z.
  std::vector<std::string> aovs;
  /// AOVs of the first surface are those of the first that is neither mirror nor clear glass, as
  /// denoisers like them.
  bool aovs_follow_specular = false;
  bool operator==(const RenderSettings&) const = default;

  /// The pixels that are rendered.
  [[nodiscard]] Rect window() const { return crop.value_or(Rect{0, 0, width, height}); }
};

/// In which order the tiles of a pass are handed out.
enum class TileOrder {
  hilbert,   ///< along a Hilbert curve: what one worker holds is a neighbourhood
  center,    ///< from the film's centre outwards
  scanline,  ///< in rows from the top
};
/// Its word in JSON and on command lines.
std::string_view name_of(TileOrder order);
/// Throws Error{bad_input} without a place, which names the nearest.
TileOrder tile_order_from(std::string_view name);

/// A job as a person submits it: one scene, one camera, one frame or a range, and how to render it.
/// What says when and by whom it is rendered (priority, order, focus, max_workers), when it and its
/// frames end (time limit, noise threshold), the name and the names for manifests stand outside the
/// plan digest; priority, focus and max_workers can be changed later.
struct JobSpec {
  std::string name;    ///< for people; a plain name
  int priority = 0;    ///< −100 … 100; higher first
  Digest bundle;       ///< the manifest that names the scene and its files
  std::string camera;  ///< one of the scene's; empty is its first
  FrameList frames;
  double fps = 24;  ///< frames a second, of what moves in the scene: see time_of()
  RenderSettings render;
  int tile = 64;         ///< side of a tile, pixels
  int pass = 256;        ///< most samples of a pass
  int aov_samples = 16;  ///< AOVs travel with passes that end at or before this
  bool mixed = false;    ///< take workers of any build, and give up the exactness contract
  int max_workers = 0;   ///< most workers that hold tasks of it at once; 0: no limit
  TileOrder order = TileOrder::hilbert;
  std::optional<Rect> focus;      ///< pixels of the film that are rendered first
  double time_limit_seconds = 0;  ///< from its first lease; it ends at a whole pass; 0: no limit
  /// Each frame ends at the first whole pass looked at whose noise is at most this; 0: it makes all
  /// its samples.
  double noise_threshold = 0;
  MatteNames cryptomatte;  ///< names for the manifests of its Cryptomattes

  bool operator==(const JobSpec&) const = default;
};

/// What of a job its workers are told: all but the names for manifests and the noise threshold,
/// which are the coordinator's alone (earlier workers refuse the latter for several frames).
JobSpec for_workers(JobSpec spec);

/// The moment that a frame shows, in seconds: frame 1 is the time 0.
double time_of(const JobSpec& spec, std::int32_t frame);

/// Checks every value against limits.hpp; throws Error{bad_input} that names the key. Names of
/// integrators, samplers and filters are checked where those are known: by the client before it
/// submits, and by the worker.
void check(const JobSpec& spec);

/// Throws Error{bad_input} that names the key unless it lies within the film.
void check_focus(const Rect& focus, const RenderSettings& film);

/// {"x", "y", "width", "height"}.
nlohmann::json to_json(const Rect& rect);
/// Whole numbers, 0 ≤ x, y and 1 ≤ width, height; whether it lies within a film is check_focus's.
Rect rect_from_json(const nlohmann::json& json, const std::string& path);

nlohmann::json to_json(const JobSpec& spec);
/// Reads and checks. Unknown keys are errors; lacking ones take their default, but bundle, width
/// and height are required. `path` is where the object stands, for errors.
JobSpec job_spec_from_json(const nlohmann::json& json, const std::string& path = {});

/// What is fixed when a job is accepted: which tasks there are. A pure function of the spec.
struct JobPlan {
  explicit JobPlan(const JobSpec& spec);

  JobSpec spec;
  TileGrid grid;
  PassPlan passes;
  Digest digest;  ///< of all that decides a task's meaning and bits

  [[nodiscard]] std::int64_t tasks_per_frame() const {
    return static_cast<std::int64_t>(grid.count()) * passes.count();
  }
  [[nodiscard]] std::int64_t tasks() const { return tasks_per_frame() * spec.frames.count(); }
  /// True if the task is one of this job's.
  [[nodiscard]] bool contains(const TaskId& task) const {
    return spec.frames.contains(task.frame) && task.tile < grid.count() &&
           task.pass < passes.count();
  }
};

}  // namespace tessera
