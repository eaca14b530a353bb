#include "common/job/job_spec.hpp"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/json.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"
#include "common/job/aovs.hpp"

namespace tessera {

namespace {

constexpr std::array<std::string_view, 3> order_names{"hilbert", "center", "scanline"};

/// What a scene of before there were such keys has no need of stays away, so that jobs that were
/// accepted then keep their plan's digest.
Json render_json(const RenderSettings& render) {
  Json out = {{"width", render.width},
              {"height", render.height},
              {"samples", render.samples},
              {"bounces", render.bounces},
              {"integrator", render.integrator},
              {"sampler", render.sampler},
              {"filter", render.filter},
              {"filter_width", render.filter_width},
              {"light_samples", render.light_samples},
              {"seed", render.seed},
              {"aovs", render.aovs},
              {"aovs_follow_specular", render.aovs_follow_specular}};
  if (render.pixel_aspect != 1) out["pixel_aspect"] = render.pixel_aspect;
  if (render.crop) out["crop"] = to_json(*render.crop);
  if (render.clamp_direct > 0) out["clamp_direct"] = render.clamp_direct;
  if (render.clamp_indirect > 0) out["clamp_indirect"] = render.clamp_indirect;
  return out;
}

RenderSettings render_from(const Json& json, const std::string& path) {
  RenderSettings render;
  ObjectReader in(json, path);
  render.width = static_cast<int>(in.integer("width", 1, limits::film_side_max));
  render.height = static_cast<int>(in.integer("height", 1, limits::film_side_max));
  render.samples = in.integer_or("samples", 1, limits::samples_max, render.samples);
  render.bounces =
      static_cast<int>(in.integer_or("bounces", 0, limits::bounces_max, render.bounces));
  render.integrator = in.text_or("integrator", render.integrator);
  render.sampler = in.text_or("sampler", render.sampler);
  render.filter = in.text_or("filter", render.filter);
  render.filter_width =
      in.number_or("filter_width", 0, limits::filter_width_max, render.filter_width);
  render.light_samples = static_cast<int>(
      in.integer_or("light_samples", 1, limits::light_samples_max, render.light_samples));
  render.seed = static_cast<std::uint64_t>(in.integer_or("seed", 0, INT64_MAX, 0));
  render.pixel_aspect = in.number_or("pixel_aspect", limits::pixel_aspect_min,
                                     limits::pixel_aspect_max, render.pixel_aspect);
  render.clamp_direct = in.number_or("clamp_direct", 0, limits::clamp_max, 0);
  render.clamp_indirect = in.number_or("clamp_indirect", 0, limits::clamp_max, 0);
  if (const Json* crop = in.optional("crop"))
    render.crop = rect_from_json(*crop, in.path_of("crop"));
  if (const Json* aovs = in.optional("aovs")) render.aovs = names_from(*aovs, in.path_of("aovs"));
  render.aovs_follow_specular = in.boolean_or("aovs_follow_specular", false);
  in.finish();
  return render;
}

FrameRange range_from(const Json& json, const std::string& path) {
  FrameRange frames;
  ObjectReader in(json, path);
  frames.first =
      static_cast<std::int32_t>(in.integer("first", -limits::frame_max, limits::frame_max));
  frames.last = static_cast<std::int32_t>(
      in.integer_or("last", frames.first, limits::frame_max, frames.first));
  frames.step = static_cast<std::int32_t>(in.integer_or("step", 1, limits::frame_max, 1));
  in.finish();
  return frames;
}

/// A range, or an array of them.
FrameList frames_from(const Json& json, const std::string& path) {
  if (!json.is_array()) return range_from(json, path);
  if (json.empty() || json.size() > limits::frame_ranges_max)
    throw Error(ErrorKind::bad_input,
                fmt::format("expected 1 to {} ranges of frames, found {}", limits::frame_ranges_max,
                            json.size()),
                {.key = path});
  FrameList list;
  list.ranges.clear();
  for (const Json& one : json)
    list.ranges.push_back(range_from(one, fmt::format("{}[{}]", path, list.ranges.size())));
  return list;
}

Json range_json(const FrameRange& range) {
  return {{"first", range.first}, {"last", range.last}, {"step", range.step}};
}

Json frames_json(const FrameList& frames) {
  if (frames.ranges.size() == 1) return range_json(frames.ranges.front());
  Json list = Json::array();
  for (const FrameRange& range : frames.ranges) list.push_back(range_json(range));
  return list;
}

}  // namespace

std::string_view name_of(TileOrder order) {
  return order_names.at(static_cast<std::size_t>(order));
}

TileOrder tile_order_from(std::string_view name) {
  for (std::size_t i = 0; i < order_names.size(); ++i)
    if (order_names.at(i) == name) return static_cast<TileOrder>(i);
  throw Error(ErrorKind::bad_input,
              unknown_name("order", excerpt(name), {order_names.begin(), order_names.end()}));
}

nlohmann::json to_json(const Rect& rect) {
  return {{"x", rect.x}, {"y", rect.y}, {"width", rect.width}, {"height", rect.height}};
}

Rect rect_from_json(const nlohmann::json& json, const std::string& path) {
  Rect rect;
  ObjectReader in(json, path);
  rect.x = static_cast<int>(in.integer("x", 0, limits::film_side_max));
  rect.y = static_cast<int>(in.integer("y", 0, limits::film_side_max));
  rect.width = static_cast<int>(in.integer("width", 1, limits::film_side_max));
  rect.height = static_cast<int>(in.integer("height", 1, limits::film_side_max));
  in.finish();
  return rect;
}

JobSpec for_workers(JobSpec spec) {
  spec.cryptomatte = {};
  spec.noise_threshold = 0;
  return spec;
}

double time_of(const JobSpec& spec, std::int32_t frame) {
  return (static_cast<double>(frame) - 1) / spec.fps;
}

nlohmann::json to_json(const JobSpec& spec) {
  Json out = {{"name", spec.name},
              {"priority", spec.priority},
              {"bundle", spec.bundle.hex()},
              {"camera", spec.camera},
              {"frames", frames_json(spec.frames)},
              {"fps", spec.fps},
              {"render", render_json(spec.render)},
              {"tile", spec.tile},
              {"pass", spec.pass},
              {"aov_samples", spec.aov_samples},
              {"mixed", spec.mixed},
              {"max_workers", spec.max_workers},
              {"order", name_of(spec.order)},
              {"focus", spec.focus ? to_json(*spec.focus) : Json()},
              {"time_limit_seconds", spec.time_limit_seconds},
              {"noise_threshold", spec.noise_threshold}};
  if (!spec.cryptomatte.empty()) out["cryptomatte"] = to_json(spec.cryptomatte);
  return out;
}

JobSpec job_spec_from_json(const nlohmann::json& json, const std::string& path) {
  JobSpec spec;
  ObjectReader in(json, path);
  spec.name = in.text("name");
  spec.priority =
      static_cast<int>(in.integer_or("priority", -limits::priority_max, limits::priority_max, 0));
  const auto bundle = Digest::from_hex(in.text("bundle"));
  if (!bundle) in.fail("bundle", "expected a SHA-256 as 64 hexadecimal digits");
  spec.bundle = *bundle;
  spec.camera = in.text_or("camera", "");
  if (const Json* frames = in.optional("frames"))
    spec.frames = frames_from(*frames, in.path_of("frames"));
  spec.fps = in.number_or("fps", limits::fps_min, limits::fps_max, spec.fps);
  spec.render = render_from(in.required("render"), in.path_of("render"));
  spec.tile = static_cast<int>(
      in.integer_or("tile", limits::tile_side_min, limits::tile_side_max, spec.tile));
  spec.pass = static_cast<int>(in.integer_or("pass", 1, limits::pass_samples_max, spec.pass));
  spec.aov_samples =
      static_cast<int>(in.integer_or("aov_samples", 1, limits::samples_max, spec.aov_samples));
  spec.mixed = in.boolean_or("mixed", false);
  spec.max_workers = static_cast<int>(in.integer_or("max_workers", 0, limits::job_workers_max, 0));
  try {
    spec.order = tile_order_from(in.text_or("order", std::string(name_of(spec.order))));
  } catch (const Error& error) {
    if (error.place().key.empty()) in.fail("order", error.message());
    throw;
  }
  if (const Json* focus = in.optional("focus"); focus != nullptr && !focus->is_null())
    spec.focus = rect_from_json(*focus, in.path_of("focus"));
  spec.time_limit_seconds = in.number_or("time_limit_seconds", 0, limits::time_limit_max, 0);
  spec.noise_threshold = in.number_or("noise_threshold", 0, limits::noise_max, 0);
  if (const Json* names = in.optional("cryptomatte"))
    spec.cryptomatte = matte_names_from(*names, in.path_of("cryptomatte"));
  in.finish();
  check(spec);
  return spec;
}

namespace {
Digest plan_digest(const JobSpec& spec) {
  Json decisive = to_json(spec);
  for (const char* key : {"name", "priority", "max_workers", "order", "focus", "time_limit_seconds",
                          "noise_threshold", "cryptomatte"})
    decisive.erase(key);
  // Plans of jobs that were accepted before there was such a key keep their digest.
  if (spec.fps == JobSpec{}.fps) decisive.erase("fps");
  Json& render = decisive["render"];
  if (spec.render.aovs.empty()) render.erase("aovs");
  if (!spec.render.aovs_follow_specular) render.erase("aovs_follow_specular");
  decisive["plan"] = 1;  // counts changes of the rule for tiles and passes
  return digest_of(decisive.dump());
}
}  // namespace

JobPlan::JobPlan(const JobSpec& job)
    : spec(job),
      grid(job.render.width, job.render.height, job.tile, job.render.window()),
      passes(job.render.samples, job.pass),
      digest(plan_digest(job)) {}

}  // namespace tessera
