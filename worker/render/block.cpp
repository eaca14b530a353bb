#include "worker/render/block.hpp"

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/base/thread_clock.hpp"

namespace tessera::render {

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

Plan::Plan(const Scene& on, const TaskRequest& asked)
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

namespace {

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

}  // namespace

Block::Block(const Plan& plan, const Rect& rect, image::TileImage& image)
    : plan_(plan),
      rect_(rect),
      image_(image),
      trace_{.scene = plan.scene,
             .camera = plan.camera,
             .bounces = plan.request.settings.bounces,
             .light_samples = plan.request.settings.light_samples,
             .aovs = plan.request.aovs,
             .follow_specular = plan.request.settings.aovs_follow_specular,
             .closures = {},
             .questions = {}},
      sets_(samples_at_once),
      aovs_(*image.layout, plan.request.aovs, plan.scene.light_groups) {
  const AovSums::Wanted& wanted = aovs_.wanted();
  trace_.by_lobe = wanted.by_lobe;
  trace_.coordinates = wanted.coordinates;
  trace_.identities = wanted.identities;
  waiting_.reserve(samples_at_once);
  if (wanted.extras) extras_.resize(samples_at_once);
  if (wanted.by_group)
    for (SampleExtras& extras : extras_) extras.by_group.resize(plan.scene.light_groups.size());
  aovs_.clear();
}

void Block::render() {
  const SampleRange range = plan_.request.samples;
  pixel_began_ = thread_cpu_seconds();
  for (std::int64_t number = 0; number < rect_.pixels(); ++number) {
    for (std::int64_t index = range.first; index < range.end(); ++index) {
      take(number, index);
      if (waiting_.size() == samples_at_once) trace_waiting();
    }
    // What a pixel takes is known only if it is alone.
    if (aovs_.wanted().time) trace_waiting();
  }
  trace_waiting();
}

Block::Pixel Block::pixel(std::int64_t number) const {
  return {rect_.x + static_cast<int>(number % rect_.width),
          rect_.y + static_cast<int>(number / rect_.width)};
}

void Block::take(std::int64_t number, std::int64_t index) {
  const auto [x, y] = pixel(number);
  PixelSets& sets = sets_[static_cast<std::size_t>(number) % sets_.size()];
  if (index == plan_.request.samples.first)
    sets.start(
        pixel_hash(plan_.seed, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)));
  CameraSample& sample = waiting_.emplace_back(leave_camera(plan_, sets, x, y, index));
  if (extras_.empty()) return;
  sample.record.extras = &extras_[waiting_.size() - 1];
  sample.record.extras->clear();
}

void Block::trace_waiting() {
  if (waiting_.empty()) return;
  plan_.integrator(trace_, waiting_);
  for (CameraSample& sample : waiting_) fold(sample.record);
  waiting_.clear();
}

void Block::fold(SampleRecord& record) {
  if (!record.finite()) {
    record.clear();
    ++rejected_;
  }
  sums_.add(record);
  aovs_.add(record);
  if (++folded_samples_ == plan_.request.samples.count) finish_pixel();
}

void Block::finish_pixel() {
  aovs_.finish();
  if (aovs_.wanted().time) {
    const double now = thread_cpu_seconds();
    aovs_.take_time(now - pixel_began_);
    pixel_began_ = now;
  }
  const auto [x, y] = pixel(folded_pixels_);
  const Rect& window = image_.window;
  const std::size_t pixels = image_.pixels();
  const auto at = static_cast<std::size_t>(y - window.y) * static_cast<std::size_t>(window.width) +
                  static_cast<std::size_t>(x - window.x);
  for (std::size_t c = 0; c < image_.channels(); ++c)
    image_.values[c * pixels + at] =
        c <= image::M2_B ? sums_.value(c) : aovs_.value(c, plan_.request.samples.count);
  sums_ = {};
  aovs_.clear();
  folded_samples_ = 0;
  ++folded_pixels_;
}

}  // namespace tessera::render
