#include "client/describe.hpp"

#include <fmt/format.h>

#include "common/base/build_info.hpp"
#include "common/base/error.hpp"

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
  add_look(command, line.fetch.exposure, line.fetch.view, ".png");
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
      return focus(settings, job, rect_from(*line.focus, "--focus"));
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
  CLI::App& command = add_each_worker(app, line, "quarantine",
                                      "Give workers no more tasks until they are released, by "
                                      "number or name: all of the name, also "
                                      "those that are not connected");
  command
      .add_option("--reason", line.quarantine.reason, "Why, for whoever asks and for their logs")
      ->type_name("TEXT");
  command.callback([&line] {
    line.command = [&line](const Settings& settings) {
      return quarantine(settings, line.quarantine);
    };
  });
  add_each_worker(app, line, "release",
                  "Give quarantined workers tasks again, by number or name: all of the name")
      .callback([&line] {
        line.command = [&line](const Settings& settings) {
          return release(settings, line.quarantine.workers);
        };
      });
}

void add_info(CLI::App& app, Line& line) {
  CLI::App& command = *app.add_subcommand(
      "info", "Count what a scene holds: triangles, materials, lights, cameras, what is not shown");
  command.add_option("scene", line.info.scene, "The scene: .json, .gltf or .glb")->required();
  add_overrides(command, line.info.overrides);
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
  describe_jobs(app, line);
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
  add_each(app, line, "purge",
           "Remove jobs that have ended from the server for good, with their pictures", purge);
  add_each(app, line, "pause", "Pause jobs", pause);
  add_each(app, line, "resume", "Go on with paused jobs", resume);
  add_extend(app, line);
  for (CLI::App* command : app.get_subcommands({}))
    command->footer("The options of tessera itself stand here too: see tessera --help.");
}

}  // namespace tessera::client
