#include <fmt/format.h>

#include <string>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"
#include "common/job/aovs.hpp"
#include "common/job/job_spec.hpp"

/// What a job may ask for.
namespace tessera {

namespace {

[[noreturn]] void bad(const char* key, const std::string& message) {
  throw Error(ErrorKind::bad_input, message, {.key = key});
}

void within(const char* key, std::int64_t value, std::int64_t low, std::int64_t high) {
  if (value < low || value > high)
    bad(key, fmt::format("expected a whole number from {} to {}, found {}", low, high, value));
}

/// Along one side of a rectangle.
struct Span {
  int first, count;
};
void check_span(const std::string& first_key, const std::string& count_key, const Span& span,
                const Span& all) {
  const int end = all.first + all.count;
  within(first_key.c_str(), span.first, all.first, end - 1);
  within(count_key.c_str(), span.count, 1, end - span.first);
}

void check_rect(const std::string& key, const Rect& rect, const Rect& all) {
  check_span(key + ".x", key + ".width", {rect.x, rect.width}, {all.x, all.width});
  check_span(key + ".y", key + ".height", {rect.y, rect.height}, {all.y, all.height});
}

void check_frames(const FrameList& frames) {
  if (frames.ranges.empty()) bad("frames", "expected at least one frame");
  for (std::size_t i = 0; i < frames.ranges.size(); ++i) {
    const FrameRange& range = frames.ranges[i];
    within("frames.first", range.first, -limits::frame_max, limits::frame_max);
    within("frames.last", range.last, -limits::frame_max, limits::frame_max);
    if (range.last < range.first || range.step < 1)
      bad("frames", "expected first ≤ last and step ≥ 1");
    if (i > 0 && range.first <= frames.ranges[i - 1].last)
      bad("frames", "expected each range to begin after the end of the one before");
  }
}

void check_film(const RenderSettings& render) {
  within("render.width", render.width, 1, limits::film_side_max);
  within("render.height", render.height, 1, limits::film_side_max);
  const std::int64_t pixels = static_cast<std::int64_t>(render.width) * render.height;
  if (pixels > limits::film_pixels_max)
    bad("render.width",
        fmt::format("a film of {} by {} has more than the {} pixels that a frame may have",
                    render.width, render.height, limits::film_pixels_max));
  if (render.crop) check_rect("render.crop", *render.crop, {0, 0, render.width, render.height});
  if (!(render.pixel_aspect >= limits::pixel_aspect_min &&
        render.pixel_aspect <= limits::pixel_aspect_max))
    bad("render.pixel_aspect", fmt::format("expected a number from {} to {}",
                                           limits::pixel_aspect_min, limits::pixel_aspect_max));
}

void check_samples(const RenderSettings& render) {
  for (const auto& [key, value] : {std::pair("render.clamp_direct", render.clamp_direct),
                                   std::pair("render.clamp_indirect", render.clamp_indirect)})
    if (!(value >= 0 && value <= limits::clamp_max))
      bad(key, fmt::format("expected a number from 0 (off) to {}", limits::clamp_max));
  within("render.samples", render.samples, 1, limits::samples_max);
  within("render.bounces", render.bounces, 0, limits::bounces_max);
  within("render.light_samples", render.light_samples, 1, limits::light_samples_max);
  for (const auto& [key, name] :
       {std::pair("render.integrator", &render.integrator),
        std::pair("render.sampler", &render.sampler), std::pair("render.filter", &render.filter)})
    if (!is_plain_name(*name)) bad(key, "expected 1 to 128 bytes without control characters");
  if (!(render.filter_width >= 0 && render.filter_width <= limits::filter_width_max))
    bad("render.filter_width",
        fmt::format("expected a number from 0 to {}", limits::filter_width_max));
  if (render.seed > static_cast<std::uint64_t>(INT64_MAX))
    bad("render.seed",
        fmt::format("expected a whole number from 0 to {}, found {}", INT64_MAX, render.seed));
}

/// When it ends before all samples are made.
void check_ends(const JobSpec& spec) {
  if (!(spec.time_limit_seconds >= 0 && spec.time_limit_seconds <= limits::time_limit_max))
    bad("time_limit_seconds",
        fmt::format("expected a number from 0 to {}", limits::time_limit_max));
  if (spec.time_limit_seconds > 0 && spec.frames.count() > 1)
    bad("time_limit_seconds", "expected a job of one frame, to limit its time");
  if (!(spec.noise_threshold >= 0 && spec.noise_threshold <= limits::noise_max))
    bad("noise_threshold", fmt::format("expected a number from 0 to {}", limits::noise_max));
}

void check_tasks(const JobSpec& spec) {
  const RenderSettings& render = spec.render;
  const std::int64_t tiles =
      TileGrid(render.width, render.height, spec.tile, render.window()).count();
  const std::int64_t passes = render.samples / spec.pass + 6;
  if (tiles > limits::tasks_max / passes / spec.frames.count())
    bad("tile", fmt::format("{} tiles, about {} passes and {} frames are more than the {} tasks "
                            "that a job may have",
                            tiles, passes, spec.frames.count(), limits::tasks_max));
}

}  // namespace

void check_focus(const Rect& focus, const RenderSettings& film) {
  check_rect("focus", focus, film.window());
}

void check(const JobSpec& spec) {
  if (!is_plain_name(spec.name)) bad("name", "expected 1 to 128 bytes without control characters");
  within("priority", spec.priority, -limits::priority_max, limits::priority_max);
  if (spec.camera.size() > 256 || !is_utf8(spec.camera))
    bad("camera", "expected at most 256 bytes of UTF-8");
  check_film(spec.render);
  check_samples(spec.render);
  check_frames(spec.frames);
  if (!(spec.fps >= limits::fps_min && spec.fps <= limits::fps_max))
    bad("fps", fmt::format("expected a number from {} to {}", limits::fps_min, limits::fps_max));
  within("tile", spec.tile, limits::tile_side_min, limits::tile_side_max);
  check_aovs(spec.render.aovs, spec.tile);
  check(spec.cryptomatte);
  within("pass", spec.pass, 1, limits::pass_samples_max);
  within("max_workers", spec.max_workers, 0, limits::job_workers_max);
  within("aov_samples", spec.aov_samples, 1, limits::samples_max);
  if (spec.focus) check_focus(*spec.focus, spec.render);
  check_ends(spec);
  check_tasks(spec);
}

}  // namespace tessera
