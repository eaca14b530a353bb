#include "client/job_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <iterator>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/job/aovs.hpp"
#include "common/scene/light_groups.hpp"
#include "common/scene/names.hpp"
#include "common/scene/object_names.hpp"
#include "common/scene/shadow_catchers.hpp"

namespace tessera::client {

namespace {

/// A person wrote a flag, so an error names the flag and not the job's key.
Error at_flag(const Error& error) {
  std::string key = error.place().key;
  if (key.starts_with("render.")) key = key.substr(7);
  if (key == "width" || key == "height") key = "size";
  for (const char* rect : {"focus", "crop"})
    if (key.starts_with(rect + std::string("."))) key = rect;
  if (key == "time_limit_seconds") key = "time";
  if (key == "noise_threshold") key = "noise";
  std::replace(key.begin(), key.end(), '_', '-');
  return Error(error.kind(), error.message(), {.file = {}, .key = key.empty() ? key : "--" + key});
}

template <class Value, class Given>
void take(Value& value, const std::optional<Given>& given) {
  if (given) value = *given;
}

/// A camera's name stays as it is; a number that is no camera's name stands for the camera of that
/// number, from 0.
std::string camera_name(const scene::Scene& scene, const std::string& camera) {
  std::size_t number = 0;
  const char* const last = camera.data() + camera.size();
  const auto [end, problem] = std::from_chars(camera.data(), last, number);
  const bool is_name = std::any_of(scene.cameras.begin(), scene.cameras.end(),
                                   [&](const auto& one) { return one.name == camera; });
  if (is_name || problem != std::errc() || end != last || number >= scene.cameras.size())
    return camera;
  return scene.cameras[number].name;
}

void check_camera(const scene::Scene& scene, const std::string& camera) {
  std::vector<std::string_view> names;
  for (const scene::Camera& one : scene.cameras) names.push_back(one.name);
  scene::check_name("camera", camera, names, "camera");
}

TileOrder order_from(const std::string& name) {
  try {
    return tile_order_from(name);
  } catch (const Error& error) {
    throw Error(error.kind(), error.message(), {.file = {}, .key = "order"});
  }
}

/// The name of a job that was given none: its scene's, or its file's.
std::string name_of(const scene::Scene& scene, const JobOptions& options) {
  if (options.name) return *options.name;
  if (!scene.name.empty()) return scene.name;
  return options.scene.stem().string();
}

std::vector<std::string> texts(const std::vector<std::string_view>& names) {
  return {names.begin(), names.end()};
}

/// For the manifests of those Cryptomattes that the job asks for; what is left out of them is said
/// in `notes`.
MatteNames matte_names(const std::vector<std::string>& aovs, const scene::Scene& scene,
                       std::vector<std::string>* notes) {
  MatteNames names;
  for (const AovUse& use : aov_uses(aovs)) {
    if (use.aov == Aov::crypto_object) names.objects = texts(scene::object_names(scene).names);
    if (use.aov == Aov::crypto_material)
      names.materials = texts(scene::material_names(scene).names);
  }
  FittingNames fit = fitting(std::move(names));
  if (notes != nullptr)
    std::move(fit.left_out.begin(), fit.left_out.end(), std::back_inserter(*notes));
  return fit.names;
}

/// A threshold does not see what such a picture may be all of.
void note_unmeasured_shadows(const JobSpec& spec, const scene::Scene& scene,
                             std::vector<std::string>* notes) {
  if (notes == nullptr || spec.noise_threshold == 0 || !scene::has_shadow_catchers(scene)) return;
  notes->emplace_back(
      "--noise does not measure the noise of shadows on shadow catchers: a picture of these alone "
      "ends at the first look");
}

FrameList frames_at_flag(const std::string& text) {
  try {
    return frames_from_text(text);
  } catch (const Error& error) {
    throw Error(error.kind(), error.message(), {.file = {}, .key = "frames"});
  }
}

}  // namespace

Size size_from(std::string_view text) {
  Size out;
  const char* const last = text.data() + text.size();
  const auto width = std::from_chars(text.data(), last, out.width);
  if (width.ec == std::errc() && width.ptr != last && *width.ptr == 'x') {
    const auto height = std::from_chars(width.ptr + 1, last, out.height);
    if (height.ec == std::errc() && height.ptr == last) return out;
  }
  throw Error(ErrorKind::bad_input,
              fmt::format("expected WIDTHxHEIGHT in pixels, such as 1920x1080, found \"{}\"",
                          text.substr(0, 64)),
              {.file = {}, .key = "--size"});
}

namespace {
/// Whole numbers without signs, each behind its sign of `before`.
std::optional<std::array<int, 4>> numbers_behind(std::string_view before, std::string_view text) {
  std::array<int, 4> out{};
  const char* at = text.data();
  const char* const last = text.data() + text.size();
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (i > 0 && (at == last || *at++ != before[i])) return std::nullopt;
    if (at == last || *at < '0' || *at > '9') return std::nullopt;
    const auto [end, problem] = std::from_chars(at, last, out.at(i));
    if (problem != std::errc()) return std::nullopt;
    at = end;
  }
  if (at != last) return std::nullopt;
  return out;
}
}  // namespace

Rect rect_from(std::string_view text, const char* flag) {
  if (const auto size_first = numbers_behind(" x++", text)) {
    const auto [width, height, x, y] = *size_first;
    return {x, y, width, height};
  }
  if (const auto place_first = numbers_behind(" ,,,", text)) {
    const auto [x, y, width, height] = *place_first;
    return {x, y, width, height};
  }
  throw Error(ErrorKind::bad_input,
              fmt::format("expected WIDTHxHEIGHT+X+Y or X,Y,WIDTH,HEIGHT in pixels, such as "
                          "256x128+640+300, found \"{}\"",
                          excerpt(text)),
              {.file = {}, .key = flag});
}

double time_from(std::string_view text) {
  constexpr std::array<std::pair<char, double>, 4> units{
      {{'d', 86400.0}, {'h', 3600.0}, {'m', 60.0}, {'s', 1.0}}};
  const auto* unit = units.begin();
  double out = 0;
  const char* at = text.data();
  const char* const last = text.data() + text.size();
  const bool bare = std::all_of(at, last, [](char c) { return c >= '0' && c <= '9'; });
  bool good = at != last;
  while (good && at != last) {
    std::uint32_t value = 0;
    const auto [end, problem] = std::from_chars(at, last, value);
    at = end;
    good = problem == std::errc();
    if (good && !bare) {
      const char letter = at == last ? '\0' : *at++;
      unit = std::find_if(unit, units.end(), [&](const auto& one) { return one.first == letter; });
      good = unit != units.end();
    }
    if (good) out += value * (bare ? 1.0 : (unit++)->second);
  }
  if (good && out > 0) return out;
  throw Error(ErrorKind::bad_input,
              fmt::format("expected a time such as 90 (seconds), 10m or 1h30m, found \"{}\"",
                          excerpt(text)),
              {.file = {}, .key = "--time"});
}

JobSpec job_from(const scene::Scene& scene, const JobOptions& options, const Digest& bundle,
                 std::vector<std::string>* notes) {
  JobSpec spec;
  spec.name = name_of(scene, options);
  spec.priority = options.priority;
  spec.bundle = bundle;
  spec.render = scene.render;
  spec.mixed = options.mixed;
  take(spec.render.width, options.width);
  take(spec.render.height, options.height);
  take(spec.camera, options.camera);
  take(spec.render.samples, options.samples);
  take(spec.render.bounces, options.bounces);
  take(spec.render.integrator, options.integrator);
  take(spec.render.sampler, options.sampler);
  take(spec.render.filter, options.filter);
  take(spec.render.filter_width, options.filter_width);
  take(spec.render.light_samples, options.light_samples);
  take(spec.render.seed, options.seed);
  take(spec.render.aovs, options.aovs);
  take(spec.render.aovs_follow_specular, options.aovs_follow_specular);
  take(spec.aov_samples, options.aov_samples);
  take(spec.tile, options.tile);
  take(spec.pass, options.pass);
  take(spec.fps, options.fps);
  take(spec.max_workers, options.max_workers);
  take(spec.time_limit_seconds, options.time_limit_seconds);
  take(spec.noise_threshold, options.noise_threshold);
  take(spec.render.pixel_aspect, options.pixel_aspect);
  take(spec.render.clamp_direct, options.clamp_direct);
  take(spec.render.clamp_indirect, options.clamp_indirect);
  if (options.crop) spec.render.crop = options.crop;
  spec.focus = options.focus;
  if (scene::has_shadow_catchers(scene))
    spec.render.aovs = with_aov(std::move(spec.render.aovs), shadow_catcher_aov);
  note_unmeasured_shadows(spec, scene, notes);
  try {
    spec.cryptomatte = matte_names(spec.render.aovs, scene, notes);
    if (options.order) spec.order = order_from(*options.order);
    if (options.frames) spec.frames = frames_at_flag(*options.frames);
    if (!spec.camera.empty()) {
      spec.camera = camera_name(scene, spec.camera);
      check_camera(scene, spec.camera);
    }
    scene::check_names(spec.render);
    scene::check_light_groups(spec.render.aovs, scene::light_groups(scene));
    check(spec);
  } catch (const Error& error) {
    throw at_flag(error);
  }
  return spec;
}

}  // namespace tessera::client
