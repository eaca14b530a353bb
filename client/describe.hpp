#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/commands.hpp"
#include "client/settings.hpp"

namespace tessera::client {

/// What the parser fills; each command's `run` uses its part.
struct Line {
  GivenSettings flags;
  bool json = false;
  std::optional<std::string> size, crop, focus, time;  ///< as they were given
  RenderOptions render;                                ///< its `job` is submit's too
  WedgeOptions wedge;
  FetchOptions fetch;
  SetOptions set;
  QuarantineOptions quarantine;  ///< its `workers` are drain's and release's too
  InfoOptions info;
  std::string job;                    ///< of a command that takes something behind it
  std::optional<std::string> frames;  ///< of fetch
  std::int64_t samples = 0;           ///< of extend
  std::vector<std::string> jobs;
  std::function<int(const Settings&)> command;
};

/// Every flag and command, told to the parser, which fills `line`. Both must live until the command
/// has run.
void describe(CLI::App& app, Line& line);

// ---- describe_jobs.cpp ----
/// render, wedge, submit.
void describe_jobs(CLI::App& app, Line& line);
/// Flags that say something of a scene in place of its file.
void add_overrides(CLI::App& command, SceneOverrides& overrides);
/// --exposure and --view.
void add_look(CLI::App& command, double& exposure, std::string& view, const char* of);
void add_frames(CLI::App& command, std::optional<std::string>& frames, const char* about);

}  // namespace tessera::client
