#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/image/tile.hpp"
#include "worker/render/aov_sums.hpp"
#include "worker/render/camera.hpp"
#include "worker/render/filter.hpp"
#include "worker/render/integrators/integrator.hpp"
#include "worker/render/pixel.hpp"
#include "worker/render/render_task.hpp"
#include "worker/render/sampler.hpp"

namespace tessera::render {

/// The scene's camera of this name, or its first; throws Error{bad_input}.
const scene::Camera& camera_of(const Scene& scene, const std::string& name);

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

  /// Throws Error{bad_input} for an unknown name.
  Plan(const Scene& on, const TaskRequest& asked);
};

/// Renders some pixels of a task, in one thread. Samples of several pixels go side by side where
/// the task takes few of each.
class Block {
 public:
  /// `rect` lies within the image's window; the plan and the image must outlive the block.
  Block(const Plan& plan, const Rect& rect, image::TileImage& image);
  void render();

  [[nodiscard]] std::int64_t rays() const { return trace_.rays; }
  [[nodiscard]] std::int64_t rejected() const { return rejected_; }

 private:
  /// A pixel by its number within the block.
  struct Pixel {
    int x, y;
  };
  [[nodiscard]] Pixel pixel(std::int64_t number) const;
  void take(std::int64_t number, std::int64_t index);
  void trace_waiting();
  void fold(SampleRecord& record);
  void finish_pixel();

  const Plan& plan_;
  Rect rect_;
  image::TileImage& image_;
  Trace trace_;
  std::vector<CameraSample> waiting_;  ///< in order of pixels, and of samples within them
  std::vector<SampleExtras> extras_;   ///< of those, or none: nobody asks for them
  std::vector<PixelSets> sets_;        ///< of pixel n at n modulo their number
  // Of the pixel that is folded:
  std::int64_t folded_pixels_ = 0;  ///< before it
  std::int64_t folded_samples_ = 0;
  PixelSums sums_;
  AovSums aovs_;
  double pixel_began_ = 0;
  std::int64_t rejected_ = 0;
};

}  // namespace tessera::render
