#include "client/job_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/scene/names.hpp"

namespace tessera::client {

namespace {

/// A person wrote a flag, so an error names the flag and not the job's key.
Error at_flag(const Error& error) {
  std::string key = error.place().key;
  if (key.starts_with("render.")) key = key.substr(7);
  if (key == "width" || key == "height") key = "size";
  std::replace(key.begin(), key.end(), '_', '-');
  return Error(error.kind(), error.message(), {.file = {}, .key = key.empty() ? key : "--" + key});
}

template <class Value, class Given>
void take(Value& value, const std::optional<Given>& given) {
  if (given) value = *given;
}

void check_camera(const scene::Scene& scene, const std::string& camera) {
  std::vector<std::string_view> names;
  for (const scene::Camera& one : scene.cameras) names.push_back(one.name);
  scene::check_name("camera", camera, names, "camera");
}

/// The name of a job that was given none: its scene's, or its file's.
std::string name_of(const scene::Scene& scene, const JobOptions& options) {
  if (options.name) return *options.name;
  if (!scene.name.empty()) return scene.name;
  return options.scene.stem().string();
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

JobSpec job_from(const scene::Scene& scene, const JobOptions& options, const Digest& bundle) {
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
  take(spec.tile, options.tile);
  take(spec.pass, options.pass);
  try {
    if (!spec.camera.empty()) check_camera(scene, spec.camera);
    scene::check_names(spec.render);
    check(spec);
  } catch (const Error& error) {
    throw at_flag(error);
  }
  return spec;
}

}  // namespace tessera::client
