#include <fmt/format.h>
#include <fmt/ranges.h>

#include "client/describe.hpp"
#include "common/job/aovs.hpp"
#include "common/scene/names.hpp"

/// The commands that make jobs, and their many flags.
namespace tessera::client {

namespace {

template <class Names>
std::string one_of(const Names& names) {
  return fmt::format("One of {}; else the scene's", fmt::join(names, ", "));
}

void add_job_options(CLI::App& command, Line& line, JobOptions& job) {
  command.add_option("scene", job.scene, "The scene file")->required()->type_name("SCENE");
  command.add_option("--size", line.size, "Film in pixels; else the scene's")->type_name("WxH");
  command
      .add_option("--pixel-aspect", job.pixel_aspect,
                  "Width of a pixel over its height; else the scene's")
      ->type_name("X");
  command
      .add_option("--crop", line.crop,
                  "Render these pixels of the film alone, each as in the whole picture: "
                  "WxH+X+Y or X,Y,W,H")
      ->type_name("RECTANGLE");
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
  command
      .add_option("--clamp-direct", job.clamp_direct,
                  "Most that light from one surface may add to a sample; biased; 0 is off (0)")
      ->type_name("X");
  command
      .add_option("--clamp-indirect", job.clamp_indirect,
                  "The same of light that met several surfaces: no fireflies, and caustics darker")
      ->type_name("X");
  command.add_option("--seed", job.seed, "Another seed gives other noise")->type_name("N");
  command
      .add_option("--aovs", job.aovs,
                  fmt::format("Outputs beside the picture, in place of the scene's or albedo, N "
                              "and Z. {}",
                              fmt::join(aov_names(), ", ")))
      ->delimiter(',')
      ->type_name("NAME,…");
  command.add_flag("--aovs-follow-specular", job.aovs_follow_specular,
                   "albedo and N of what is seen in mirrors and through clear glass, in place of "
                   "their own");
  command
      .add_option("--aov-samples", job.aov_samples,
                  "AOVs that are no light come with passes that end at or before this many samples "
                  "of a pixel (16)")
      ->type_name("N");
  command.add_option("--tile", job.tile, "Side of a tile in pixels (64)")->type_name("N");
  command.add_option("--pass", job.pass, "Most samples of a pass (256)")->type_name("N");
  command
      .add_option("--camera", job.camera,
                  "One of the scene's cameras, by its name or by its number from 0; else its first")
      ->type_name("NAME");
  add_overrides(command, job.overrides);
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
  command
      .add_option("--noise", job.noise_threshold,
                  "End each frame at a whole pass when its pixels are off by this share of their "
                  "light in the mean: 0.01 is one in a hundred; --samples is then the most")
      ->type_name("LEVEL");
  command.add_option("--max-workers", job.max_workers, "Most workers at once; 0: no limit (0)")
      ->type_name("N");
}

/// What was given as text becomes values.
void take_texts(const Line& line, JobOptions& job) {
  if (line.size) {
    const Size size = size_from(*line.size);
    job.width = size.width;
    job.height = size.height;
  }
  if (line.focus) job.focus = rect_from(*line.focus, "--focus");
  if (line.crop) job.crop = rect_from(*line.crop, "--crop");
  if (line.time) job.time_limit_seconds = time_from(*line.time);
}

void add_frames_of_job(CLI::App& command, JobOptions& job) {
  add_frames(command, job.frames, "Which frames: 7, 1-240, 1-240x2 or 1,5,10-20 (1)");
  command
      .add_option("--fps", job.fps,
                  "Frames a second, of what moves in the scene; frame 1 is its first moment (24)")
      ->type_name("N");
}

void add_by_path(CLI::App& command, JobOptions& job) {
  command.add_flag("--by-path", job.by_path,
                   "Send no files: workers read them where they lie, under the same paths, on a "
                   "disk that all share (tessera-worker --asset-root)");
}

/// How many of what a farm of the command's own has.
template <class Options>
void add_own_farm(CLI::App& command, Options& options, const char* workers) {
  command.add_option("--workers", options.workers, workers)
      ->type_name("K")
      ->check(CLI::Range(1, 1024));
  command
      .add_option("--threads", options.threads,
                  "Threads of each of these workers; else the machine's, divided")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
}

void add_render(CLI::App& app, Line& line) {
  CLI::App& command = *app.add_subcommand(
      "render",
      "Render one picture here: starts a coordinator and workers, and leaves nothing but the file");
  RenderOptions& options = line.render;
  add_job_options(command, line, options.job);
  add_frames_of_job(command, options.job);
  command
      .add_option("-o,--output", options.output,
                  "The picture: .exr or .png; #### in its name is the place of a frame's number")
      ->required()
      ->type_name("FILE");
  add_look(command, options.exposure, options.view, ".png");
  add_own_farm(command, options, "Worker processes (1)");
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
  add_look(command, options.exposure, options.view, "the sheet");
  add_by_path(command, options.job);
  add_own_farm(command, options,
               "Worker processes of a farm of its own (1); asks for one although TESSERA_SERVER or "
               "the config file names a server");
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
  add_frames_of_job(command, job);
  command.add_option("--priority", job.priority, "-100 to 100, higher first (0)")->type_name("N");
  add_by_path(command, job);
  command.add_flag("--mixed", job.mixed, "Take workers of any build, and give up identical bits");
  command.callback([&line] {
    line.command = [&line](const Settings& settings) {
      take_texts(line, line.render.job);
      return submit(settings, line.render.job);
    };
  });
}

}  // namespace

void add_overrides(CLI::App& command, SceneOverrides& overrides) {
  command
      .add_option(
          "--env", overrides.environment,
          "Environment in place of the scene's: a picture (.hdr, .exr, …), R,G,B, or studio")
      ->type_name("FILE|R,G,B");
  command
      .add_option("--env-strength", overrides.environment_strength,
                  "Multiplies the environment; else as the scene says (1)")
      ->type_name("S")
      ->check(CLI::Range(0., 1e12));
  command
      .add_option("--env-rotate", overrides.environment_rotation,
                  "Turns the environment about +y, counter-clockwise as seen from above (0)")
      ->type_name("DEGREES")
      ->check(CLI::Range(-36000., 36000.));
  command.add_option("--variant", overrides.variant, "Variant of a glTF file's materials")
      ->type_name("NAME");
  command
      .add_option("--units", overrides.units,
                  "What a glTF file's lights without a size are in: physical (candela, lux) or "
                  "blender (these times 683, as Blender's lighting mode Standard writes them)")
      ->type_name("NAME");
}

void add_look(CLI::App& command, double& exposure, std::string& view, const char* of) {
  command.add_option("--exposure", exposure, fmt::format("Stops, for {}", of))
      ->type_name("STOPS")
      ->check(CLI::Range(-64., 64.));
  command
      .add_option("--view", view,
                  fmt::format("How {} shows light: srgb, which cuts off what is beyond 1, or "
                              "filmic, which lets it run out softly (srgb)",
                              of))
      ->type_name("NAME");
}

void add_frames(CLI::App& command, std::optional<std::string>& frames, const char* about) {
  command.add_option("--frames", frames, about)->type_name("LIST");
}

void describe_jobs(CLI::App& app, Line& line) {
  add_render(app, line);
  add_wedge(app, line);
  add_submit(app, line);
}

}  // namespace tessera::client
