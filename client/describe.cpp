#include "client/describe.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/base/build_info.hpp"
#include "common/base/error.hpp"
#include "common/scene/names.hpp"

namespace tessera::client {

namespace {

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

void add_job_options(CLI::App& command, Line& line, JobOptions& job) {
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
  command
      .add_option("--camera", job.camera,
                  "One of the scene's cameras, by its name or by its number from 0; else its first")
      ->type_name("NAME");
  command.add_option("--name", job.name, "The job's name; else the scene's")->type_name("NAME");
  command
      .add_option("--order", job.order,
                  "Order of the tiles within a pass: hilbert (a curve through neighbours, the "
                  "default), center (from the centre outwards) or scanline")
      ->type_name("NAME");
  command
      .add_option("--focus", line.focus,
                  "Render this rectangle of pixels first; tessera focus moves it later")
      ->type_name("WxH+X+Y");
  command
      .add_option("--time", line.time,
                  "End at a whole pass when this much time is up: 90 (seconds), 10m, 1h30m; "
                  "--samples is then the most")
      ->type_name("LIMIT");
  command.add_option("--max-workers", job.max_workers, "Most workers at once; 0: no limit (0)")
      ->type_name("N");
}

void add_frames(CLI::App& command, std::optional<std::string>& frames, const char* about) {
  command.add_option("--frames", frames, about)->type_name("LIST");
}

/// What was given as text becomes values.
void take_texts(const Line& line, JobOptions& job) {
  if (line.size) {
    const Size size = size_from(*line.size);
    job.width = size.width;
    job.height = size.height;
  }
  if (line.focus) job.focus = focus_from(*line.focus);
  if (line.time) job.time_limit_seconds = time_from(*line.time);
}

void add_render(CLI::App& app, Line& line) {
  CLI::App& command = *app.add_subcommand(
      "render",
      "Render one picture here: starts a coordinator and workers, and leaves nothing but the file");
  RenderOptions& options = line.render;
  add_job_options(command, line, options.job);
  add_frames(command, options.job.frames, "Which frames: 7, 1-240, 1-240x2 or 1,5,10-20 (1)");
  command
      .add_option("-o,--output", options.output,
                  "The picture: .exr or .png; #### in its name is the place of a frame's number")
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
      take_texts(line, line.render.job);
      return render(settings, line.render);
    };
  });
}

void add_wedge(CLI::App& app, Line& line) {
  CLI::App& command = *app.add_subcommand(
      "wedge",
      "Render a scene over a grid of parameters, on the named server or here, and make a contact "
      "sheet of it");
  WedgeOptions& options = line.wedge;
  add_job_options(command, line, options.job);
  command
      .add_option("--vary", options.vary,
                  "A parameter and its values: one of the flags above (samples, light_samples, …) "
                  "or a path in the scene (camera.fov, materials.white.reflectance, "
                  "shapes[3].material); a value is JSON or a bare word. The first gives the "
                  "columns, the second the rows, further ones blocks below each other")
      ->required()
      ->allow_extra_args(false)
      ->type_name("NAME=VALUE,VALUE,…");
  command.add_option("-o,--output", options.output, "The contact sheet, .png")
      ->required()
      ->type_name("FILE");
  command
      .add_option("--exr-dir", options.exr_dir,
                  "Folder for the EXRs; else one named as the sheet, without .png")
      ->type_name("FOLDER");
  command
      .add_option("--cell-width", options.cell_width,
                  "Pictures wider than this are scaled down on the sheet (512)")
      ->type_name("N")
      ->check(CLI::Range(1, 65536));
  command.add_option("--exposure", options.exposure, "Stops, for the sheet")
      ->type_name("STOPS")
      ->check(CLI::Range(-64., 64.));
  command
      .add_option("--workers", options.workers,
                  "Worker processes of a farm of its own (1); asks for one although "
                  "TESSERA_SERVER or the config file names a server")
      ->type_name("K")
      ->check(CLI::Range(1, 1024));
  command
      .add_option("--threads", options.threads,
                  "Threads of each of these workers; else the machine's, divided")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  command.callback([&line] {
    line.command = [&line](const Settings& settings) {
      take_texts(line, line.wedge.job);
      return wedge(settings, line.wedge);
    };
  });
}

void add_submit(CLI::App& app, Line& line) {
  CLI::App& command =
      *app.add_subcommand("submit", "Send a scene to the server; prints the job's number");
  JobOptions& job = line.render.job;
  add_job_options(command, line, job);
  add_frames(command, job.frames, "Which frames: 7, 1-240, 1-240x2 or 1,5,10-20 (1)");
  command.add_option("--priority", job.priority, "-100 to 100, higher first (0)")->type_name("N");
  command.add_flag("--mixed", job.mixed, "Take workers of any build, and give up identical bits");
  command.callback([&line] {
    line.command = [&line](const Settings& settings) {
      take_texts(line, line.render.job);
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
  command
      .add_option("-o,--output", line.fetch.output,
                  "The picture: .exr or .png; #### in its name is the place of a frame's number, "
                  "and asks for all frames unless some are named")
      ->required()
      ->type_name("FILE");
  auto* frame =
      command.add_option("--frame", line.fetch.frame, "Which frame; else the job's first, or all")
          ->type_name("N");
  add_frames(command, line.frames, "Which frames: 7, 1-240, 1-240x2 or 1,5,10-20");
  frame->excludes("--frames");
  command.add_option("--exposure", line.fetch.exposure, "Stops, for .png")
      ->type_name("STOPS")
      ->check(CLI::Range(-64., 64.));
  command.callback([&line] {
    line.command = [&line](const Settings& settings) {
      line.fetch.job = job_from(line.jobs.front());
      if (line.frames) line.fetch.frames = frames_from_text(*line.frames);
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

void add_extend(CLI::App& app, Line& line) {
  CLI::App& command = *app.add_subcommand(
      "extend", "Add samples to jobs that are done or under way: what they have is kept");
  command.add_option("jobs", line.jobs, "The jobs' numbers")->required()->type_name("JOB");
  command
      .add_option("--samples", line.samples, "Samples of each pixel in all, more than there are")
      ->required()
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  command.callback([&line] {
    line.command = [&line](const Settings& settings) {
      return extend(settings, jobs_from(line.jobs), line.samples);
    };
  });
}

void add_focus(CLI::App& app, Line& line) {
  CLI::App& command = *app.add_subcommand(
      "focus", "Have a rectangle of a job's pixels rendered first, or no longer");
  command.add_option("job", line.job, "The job's number")->required()->type_name("JOB");
  command.add_option("region", line.focus, "The rectangle, or none")
      ->required()
      ->type_name("WxH+X+Y|none");
  command.callback([&line] {
    line.command = [&line](const Settings& settings) {
      const JobId job = job_from(line.job);
      if (*line.focus == "none") return focus(settings, job, std::nullopt);
      return focus(settings, job, focus_from(*line.focus));
    };
  });
}

void add_set(CLI::App& app, Line& line) {
  CLI::App& command = *app.add_subcommand("set", "Change what can be changed of jobs");
  command.add_option("jobs", line.jobs, "The jobs' numbers")->required()->type_name("JOB");
  command.add_option("--priority", line.set.priority, "-100 to 100, higher first")->type_name("N");
  command.add_option("--max-workers", line.set.max_workers, "Most workers at once; 0: no limit")
      ->type_name("N");
  command.callback([&line] {
    line.command = [&line](const Settings& settings) {
      line.set.jobs = jobs_from(line.jobs);
      return set(settings, line.set);
    };
  });
}

/// A command that takes any number of workers.
CLI::App& add_each_worker(CLI::App& app, Line& line, const char* name, const char* about) {
  CLI::App& command = *app.add_subcommand(name, about);
  command.add_option("workers", line.quarantine.workers, "The workers' numbers or names")
      ->required()
      ->type_name("WORKER");
  return command;
}

void add_worker_control(CLI::App& app, Line& line) {
  add_each_worker(app, line, "drain", "Let workers finish what they hold, and leave")
      .callback([&line] {
        line.command = [&line](const Settings& settings) {
          return drain(settings, line.quarantine.workers);
        };
      });
  CLI::App& command = add_each_worker(
      app, line, "quarantine",
      "Give workers no more tasks until they are released, also when they come back");
  command
      .add_option("--reason", line.quarantine.reason, "Why, for whoever asks and for their logs")
      ->type_name("TEXT");
  command.callback([&line] {
    line.command = [&line](const Settings& settings) {
      return quarantine(settings, line.quarantine);
    };
  });
  add_each_worker(app, line, "release", "Give quarantined workers tasks again").callback([&line] {
    line.command = [&line](const Settings& settings) {
      return release(settings, line.quarantine.workers);
    };
  });
}

void add_info(CLI::App& app, Line& line) {
  CLI::App& command = *app.add_subcommand(
      "info", "Count what a scene holds: triangles, materials, lights, cameras, what is not shown");
  command.add_option("scene", line.info, "The scene: .json, .gltf or .glb")->required();
  command.callback([&line] {
    line.command = [&line](const Settings& settings) { return info(settings, line.info); };
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

}  // namespace

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
  add_wedge(app, line);
  add_submit(app, line);
  add_info(app, line);
  add_one(app, line, "watch", "Show a job's progress until it ends", watch);
  add_one(app, line, "wait", "Wait until a job ends, and say by the exit code how", wait);
  add_fetch(app, line);
  add_plain(app, line, "jobs", "List the server's jobs", jobs);
  add_one(app, line, "failures",
          "List a job's attempts that gave no result, with their reasons and logs", failures);
  add_plain(app, line, "workers", "List the server's workers", workers);
  add_focus(app, line);
  add_set(app, line);
  add_worker_control(app, line);
  add_each(app, line, "cancel", "Cancel jobs", cancel);
  add_each(app, line, "pause", "Pause jobs", pause);
  add_each(app, line, "resume", "Go on with paused jobs", resume);
  add_extend(app, line);
  for (CLI::App* command : app.get_subcommands({}))
    command->footer("The options of tessera itself stand here too: see tessera --help.");
}

}  // namespace tessera::client
