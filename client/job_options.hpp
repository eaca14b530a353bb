#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/overrides.hpp"
#include "common/job/job_spec.hpp"
#include "common/scene/description.hpp"

/// From a scene and what a command line says about it to a job. Pure.
namespace tessera::client {

struct Size {
  int width = 0;
  int height = 0;
  bool operator==(const Size&) const = default;
};
/// "WIDTHxHEIGHT" in pixels. Throws Error{bad_input}.
Size size_from(std::string_view text);

/// "WxH+X+Y" or "X,Y,W,H": a rectangle of pixels, from the film's upper left corner. Throws
/// Error{bad_input} at `flag`.
Rect rect_from(std::string_view text, const char* flag);
/// Seconds from "90", "90s", "10m", "1h30m", "2d": whole numbers, each unit once at most, the
/// larger first; a bare number is seconds. Throws Error{bad_input}.
double time_from(std::string_view text);

/// What `render` and `submit` have in common. What is absent is the scene's.
struct JobOptions {
  std::filesystem::path scene;
  std::optional<std::string> name;
  std::optional<std::string> camera;
  std::optional<int> width;
  std::optional<int> height;
  std::optional<std::int64_t> samples;
  std::optional<int> bounces;
  std::optional<std::string> integrator;
  std::optional<std::string> sampler;
  std::optional<std::string> filter;
  std::optional<double> filter_width;
  std::optional<int> light_samples;
  std::optional<std::uint64_t> seed;
  std::optional<std::vector<std::string>> aovs;
  std::optional<bool> aovs_follow_specular;
  std::optional<int> aov_samples;
  std::optional<int> tile;
  std::optional<int> pass;
  std::optional<std::string> order;
  std::optional<Rect> focus;
  std::optional<Rect> crop;
  std::optional<double> pixel_aspect;
  std::optional<double> clamp_direct;
  std::optional<double> clamp_indirect;
  std::optional<double> noise_threshold;
  std::optional<double> time_limit_seconds;
  std::optional<int> max_workers;
  std::optional<std::string> frames;  ///< as frames_from_text reads them; else frame 1
  SceneOverrides overrides;
  std::optional<double> fps;
  int priority = 0;
  bool mixed = false;
  bool by_path = false;  ///< files stay where they are, and are named by their paths
};

/// The job that the options ask for. Names of integrator, sampler, filter and camera are checked,
/// and all else that check(JobSpec) knows. Throws Error{bad_input} that names the flag or the key.
/// What the person should know of it joins `notes`, where those are wanted.
JobSpec job_from(const scene::Scene& scene, const JobOptions& options, const Digest& bundle,
                 std::vector<std::string>* notes = nullptr);

}  // namespace tessera::client
