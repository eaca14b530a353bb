#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "common/assets/bundle.hpp"
#include "common/base/digest.hpp"
#include "common/image/tile.hpp"
#include "common/job/job_spec.hpp"
#include "common/job/pass_plan.hpp"
#include "common/job/tile_grid.hpp"

/// How the agent reaches the renderer; the agent knows nothing else of it.
namespace tessera::agent {

/// A scene that is built and ready to render. Read-only, so any number of tasks may share it.
class PreparedScene {
 public:
  virtual ~PreparedScene() = default;
  /// True if a job with these settings can be rendered from it, false if it was built for jobs that
  /// look at less.
  [[nodiscard]] virtual bool serves(const RenderSettings& settings) const = 0;
};

/// One task, without the names that the farm has for it.
struct RenderRequest {
  std::int32_t frame = 0;
  Rect window;          ///< within the film
  SampleRange samples;  ///< of each pixel
  bool aovs = false;    ///< bring the AOVs too
};

struct RenderedTile {
  image::TileImage image;
  std::int64_t samples = 0;   ///< pixels × samples of the pass
  std::int64_t rays = 0;      ///< closest hits and shadow rays
  std::int64_t rejected = 0;  ///< samples that were NaN or Inf and count as black
  double seconds = 0;         ///< wall clock
  double cpu_seconds = 0;
};

/// Files of a scene: path in the bundle → where its bytes are on this machine.
using SceneFiles = std::map<std::string, std::filesystem::path>;
/// Called from any thread, now and then, with the part that is done, 0…1.
using Fraction = std::function<void(double)>;

/// Thread-safe: scenes are prepared and tasks rendered at the same time, several at once.
class TaskRenderer {
 public:
  virtual ~TaskRenderer() = default;

  /// Of all that may change a sample's bits.
  [[nodiscard]] virtual Digest build_id() const = 0;
  /// Threads that all tasks together use.
  [[nodiscard]] virtual int threads() const = 0;

  /// Reads and builds a scene that serves jobs with these settings. Empty if `stop` was asked for.
  /// Throws Error with the place if the scene cannot be built.
  virtual std::shared_ptr<const PreparedScene> prepare(const assets::Bundle& bundle,
                                                       const SceneFiles& files,
                                                       const RenderSettings& settings,
                                                       const Fraction& progress,
                                                       std::stop_token stop) = 0;
  /// Throws Error{bad_input} that names the key if the job asks for a camera, integrator, sampler
  /// or filter that is not there.
  virtual void check(const PreparedScene& scene, const JobSpec& spec) const = 0;
  /// Empty if `stop` was asked for before it was done. Throws Error.
  virtual std::optional<RenderedTile> render(const PreparedScene& scene, const JobSpec& spec,
                                             const RenderRequest& request, const Fraction& progress,
                                             std::stop_token stop) = 0;
};

}  // namespace tessera::agent
