#include "client/command_line.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>

#include "client/commands.hpp"
#include "client/interrupt.hpp"
#include "common/base/build_info.hpp"
#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/scene/names.hpp"

namespace tessera::client {

namespace {

/// What the parser fills; each command's `run` uses its part.
struct Line {
  GivenSettings flags;
  bool json = false;
  std::optional<std::string> size;
  RenderOptions render;  ///< its `job` is submit's too
  FetchOptions fetch;
  std::vector<std::string> jobs;
  std::function<int(const Settings&)> command;
};

JobId job_from(const std::string& text) {
  const auto id = job_id_from(text);
  if (!id)
    throw Error(ErrorKind::bad_input,
                fmt::format("expected a job's number, as submit prints it, found \"{}\"",
                            text.substr(0, 64)));
  return *id;
}

std::vector<JobId> jobs_from(const std::vector<std::string>& texts) {
  std::vector<JobId> out;
  for (const std::string& text : texts) out.push_back(job_from(text));
  return out;
}

template <class Names>
std::string one_of(const Names& names) {
  return fmt::format("One of {}; else the scene's", fmt::join(names, ", "));
}

void add_job_options(CLI::App& command, Line& line) {
  JobOptions& job = line.render.job;
  command.add_option("scene", job.scene, "The scene file")->required()->type_name("SCENE");
  command.add_option("--size", line.size, "Film in pixels; else the scene's")->type_name("WxH");
  command.add_option("--samples", job.samples, "Samples of each pixel; else the scene's")
      ->type_name("N");
  command.add_option("--bounces", job.bounces, "Bounces; 0 is emission and direct light")
      ->type_name("N");
  command.add_option("--filter", job.filter, one_of(scene::filter_names))->type_name("NAME");
  command
      .add_option("--filter-width", job.filter_width,
                  "Pixels from edge to edge; 0 is the filter's own")
      ->type_name("X");
  command.add_option("--integrator", job.integrator, one_of(scene::integrator_names))
      ->type_name("NAME");
  command.add_option("--sampler", job.sampler, one_of(scene::sampler_names))->type_name("NAME");
  command.add_option("--light-samples", job.light_samples, "Light samples at each hit")
      ->type_name("N");
  command.add_option("--seed", job.seed, "Another seed gives other noise")->type_name("N");
  command.add_option("--tile", job.tile, "Side of a tile in pixels (64)")->type_name("N");
  command.add_option("--pass", job.pass, "Most samples of a pass (256)")->type_name("N");
  command.add_option("--camera", job.camera, "One of the scene's cameras; else its first")
      ->type_name("NAME");
  command.add_option("--name", job.name, "The job's name; else the scene's")->type_name("NAME");
}

void take_size(Line& line) {
  if (line.size) line.render.job.size = size_from(*line.size);
}

void add_render(CLI::App& app, Line& line) {
  CLI::App& command = *app.add_subcommand(
      "render",
      "Render one picture here: starts a coordinator and workers, and leaves nothing but the file");
  add_job_options(command, line);
  RenderOptions& options = line.render;
  command.add_option("-o,--output", options.output, "The picture: .exr or .png")
      ->required()
      ->type_name("FILE");
  command.add_option("--exposure", options.exposure, "Stops, for .png")
      ->type_name("STOPS")
      ->check(CLI::Range(-64., 64.));
  command.add_option("--workers", options.workers, "Worker processes (1)")
      ->type_name("K")
      ->check(CLI::Range(1, 1024));
  command
      .add_option("--threads", options.threads,
                  "Threads of each worker; else the machine's, divided")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  command.callback([&line] {
    line.command = [&line](const Settings& settings) {
      take_size(line);
      return render(settings, line.render);
    };
  });
}

void add_submit(CLI::App& app, Line& line) {
  CLI::App& command =
      *app.add_subcommand("submit", "Send a scene to the server; prints the job's number");
  add_job_options(command, line);
  JobOptions& job = line.render.job;
  command.add_option("--priority", job.priority, "-100 to 100, higher first (0)")->type_name("N");
  command.add_flag("--mixed", job.mixed, "Take workers of any build, and give up identical bits");
  command.callback([&line] {
    line.command = [&line](const Settings& settings) {
      take_size(line);
      return submit(settings, line.render.job);
    };
  });
}

void add_fetch(CLI::App& app, Line& line) {
  CLI::App& command =
      *app.add_subcommand("fetch", "Get a job's picture, or what there is of it so far");
  command.add_option("job", line.jobs, "The job's number")
      ->required()
      ->expected(1)
      ->type_name("JOB");
  command.add_option("-o,--output", line.fetch.output, "The picture: .exr or .png")
      ->required()
      ->type_name("FILE");
  command.add_option("--frame", line.fetch.frame, "Which frame; else the job's first")
      ->type_name("N");
  command.add_option("--exposure", line.fetch.exposure, "Stops, for .png")
      ->type_name("STOPS")
      ->check(CLI::Range(-64., 64.));
  command.callback([&line] {
    line.command = [&line](const Settings& settings) {
      line.fetch.job = job_from(line.jobs.front());
      return fetch(settings, line.fetch);
    };
  });
}

/// A command that takes one job.
void add_one(CLI::App& app, Line& line, const char* name, const char* about,
             int (*run)(const Settings&, JobId)) {
  CLI::App& command = *app.add_subcommand(name, about);
  command.add_option("job", line.jobs, "The job's number")
      ->required()
      ->expected(1)
      ->type_name("JOB");
  command.callback([&line, run] {
    line.command = [&line, run](const Settings& settings) {
      return run(settings, job_from(line.jobs.front()));
    };
  });
}

/// A command that takes any number of jobs.
void add_each(CLI::App& app, Line& line, const char* name, const char* about,
              int (*run)(const Settings&, const std::vector<JobId>&)) {
  CLI::App& command = *app.add_subcommand(name, about);
  command.add_option("jobs", line.jobs, "The jobs' numbers")->required()->type_name("JOB");
  command.callback([&line, run] {
    line.command = [&line, run](const Settings& settings) {
      return run(settings, jobs_from(line.jobs));
    };
  });
}

/// A command that takes nothing.
void add_plain(CLI::App& app, Line& line, const char* name, const char* about,
               int (*run)(const Settings&)) {
  CLI::App& command = *app.add_subcommand(name, about);
  command.callback([&line, run] { line.command = run; });
}

constexpr const char* footer =
    "Where flags are lacking, TESSERA_SERVER and TESSERA_TOKEN are taken, then \"server\" and "
    "\"token\" in\n"
    "~/.config/tessera/config.json. Exit codes: 0 done, 1 failed, 2 wrong usage or bad input, 3 "
    "server not reached,\n"
    "4 refused, 130 interrupted.";

void describe(CLI::App& app, Line& line) {
  app.add_option("--server", line.flags.server, "The server's HTTP address (http://127.0.0.1:8420)")
      ->type_name("URL");
  app.add_option("--token", line.flags.token, "The token that the server asks for")
      ->type_name("TOKEN");
  app.add_flag("--json", line.json, "Answer in JSON, one object a line");
  app.set_version_flag("--version", fmt::format("tessera {} ({})", version(), build_commit()));
  app.require_subcommand(1);
  app.fallthrough();
  app.footer(footer);
  add_render(app, line);
  add_submit(app, line);
  add_one(app, line, "watch", "Show a job's progress until it ends", watch);
  add_one(app, line, "wait", "Wait until a job ends, and say by the exit code how", wait);
  add_fetch(app, line);
  add_plain(app, line, "jobs", "List the server's jobs", jobs);
  add_plain(app, line, "workers", "List the server's workers", workers);
  add_each(app, line, "cancel", "Cancel jobs", cancel);
  add_each(app, line, "pause", "Pause jobs", pause);
  add_each(app, line, "resume", "Go on with paused jobs", resume);
  for (CLI::App* command : app.get_subcommands({}))
    command->footer("The options of tessera itself stand here too: see tessera --help.");
}

int usage_error(const CLI::App& app, const CLI::ParseError& error, int argc,
                const char* const* argv) {
  std::string message = error.what();
  std::vector<std::string_view> names;
  for (const CLI::App* command : app.get_subcommands({})) names.emplace_back(command->get_name());
  // A word in the command's place that is none deserves better than the parser's sentence.
  if (app.get_subcommands().empty() && argc > 1 && argv[1][0] != '-')
    message = unknown_name("command", argv[1], names);
  fmt::print(stderr,
             "tessera: {}\n(tessera --help, and tessera COMMAND --help, say what there is)\n",
             message);
  return exit_code(ErrorKind::bad_input);
}

int carry_out(const Line& line) {
  try {
    const Settings settings =
        settle(line.flags, environment_settings(), config_settings(config_file()), line.json);
    catch_interrupts();
    return line.command(settings);
  } catch (const Interrupted&) {
    fmt::print(stderr, "tessera: interrupted\n");
    return 130;
  } catch (const Error& error) {
    fmt::print(stderr, "tessera: {}\n", error.what());
    return exit_code(error.kind());
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "tessera: not enough memory\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "tessera: {}\n", error.what());
  }
  return exit_code(ErrorKind::failed);
}

}  // namespace

int run(int argc, const char* const* argv) {
  CLI::App app{"Tessera: one frame over many workers", "tessera"};
  Line line;
  describe(app, line);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    return usage_error(app, error, argc, argv);
  }
  return carry_out(line);
}

}  // namespace tessera::client
