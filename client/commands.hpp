#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "client/job_options.hpp"
#include "client/settings.hpp"
#include "common/job/task.hpp"

/// One function a command, each in the file of its name. They print what the command answers on
/// standard output, progress and remarks on standard error, and give the exit code; what goes wrong
/// is thrown.
namespace tessera::client {

struct RenderOptions {
  JobOptions job;
  std::filesystem::path output;
  double exposure = 0;        ///< stops; PNG alone
  std::string view = "srgb";  ///< PNG alone
  int workers = 1;
  int threads = 0;  ///< of each worker; 0: the machine's, divided among the workers
};
int render(const Settings& settings, const RenderOptions& options);

struct WedgeOptions {
  JobOptions job;
  std::vector<std::string> vary;  ///< as they were given: NAME=VALUE,…
  std::filesystem::path output;   ///< the contact sheet, .png
  std::filesystem::path exr_dir;  ///< empty: named as the sheet, without its ending
  int cell_width = 512;           ///< wider pictures are scaled down on the sheet
  double exposure = 0;            ///< stops; the sheet alone
  std::string view = "srgb";      ///< the sheet alone
  std::optional<int> workers;     ///< of a farm of its own
  std::optional<int> threads;     ///< of each of its workers
};
int wedge(const Settings& settings, const WedgeOptions& options);

/// What a scene holds and what of it cannot be shown.
struct InfoOptions {
  std::filesystem::path scene;
  SceneOverrides overrides;
};
int info(const Settings& settings, const InfoOptions& options);

int extend(const Settings& settings, const std::vector<JobId>& jobs, std::int64_t samples);
int submit(const Settings& settings, const JobOptions& options);
int watch(const Settings& settings, JobId job);
int wait(const Settings& settings, JobId job);

struct FetchOptions {
  JobId job = 0;
  std::filesystem::path output;
  std::optional<std::int32_t> frame;  ///< one of them
  std::optional<FrameList>
      frames;                 ///< several; else the job's first, or all where # is in the name
  double exposure = 0;        ///< stops; PNG alone
  std::string view = "srgb";  ///< PNG alone
};
int fetch(const Settings& settings, const FetchOptions& options);

/// Nothing: no focus any more.
int focus(const Settings& settings, JobId job, const std::optional<Rect>& region);

struct SetOptions {
  std::vector<JobId> jobs;
  std::optional<int> priority;
  std::optional<int> max_workers;  ///< 0: no limit
};
int set(const Settings& settings, const SetOptions& options);

int jobs(const Settings& settings);
/// The newest attempts at a job's tasks that gave no result.
int failures(const Settings& settings, JobId job);
int workers(const Settings& settings);
/// Workers are named by their numbers or names.
int drain(const Settings& settings, const std::vector<std::string>& workers);
struct QuarantineOptions {
  std::vector<std::string> workers;
  std::string reason;
};
int quarantine(const Settings& settings, const QuarantineOptions& options);
int release(const Settings& settings, const std::vector<std::string>& workers);
int cancel(const Settings& settings, const std::vector<JobId>& jobs);
/// Jobs that have ended, and their pictures.
int purge(const Settings& settings, const std::vector<JobId>& jobs);
int pause(const Settings& settings, const std::vector<JobId>& jobs);
int resume(const Settings& settings, const std::vector<JobId>& jobs);

}  // namespace tessera::client
