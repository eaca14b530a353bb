#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/commands.hpp"
#include "client/farm.hpp"
#include "client/follow.hpp"
#include "client/frame_files.hpp"
#include "client/output.hpp"
#include "client/post.hpp"
#include "client/prepare.hpp"
#include "client/print.hpp"
#include "client/upload.hpp"
#include "common/base/error.hpp"

namespace tessera::client {

namespace {

constexpr std::chrono::milliseconds look{100};

Json report(const RenderOptions& options, const PreparedJob& prepared, const JobState& job,
            int threads, double elapsed) {
  return {{"output", options.output.string()},
          {"seconds", elapsed},
          {"render_seconds", job.render_seconds},
          {"width", prepared.spec.render.width},
          {"height", prepared.spec.render.height},
          {"samples", job.samples},
          {"frames", prepared.spec.frames.count()},
          {"rays", job.rays},
          {"workers", options.workers},
          {"threads", threads}};
}

}  // namespace

int render(const Settings& settings, const RenderOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const auto elapsed = [&] { return seconds(std::chrono::steady_clock::now() - start); };
  const int threads = threads_of_each(options.threads, options.workers);
  const PictureFormat format = check_output(options.output);
  const Look shown{.exposure = options.exposure, .view = view_from(options.view)};
  std::signal(SIGPIPE, SIG_IGN);  // if nobody reads the progress, the picture is still wanted

  const PreparedJob prepared = prepare(options.job);
  print_warnings(prepared.warnings);
  const FrameList& frames = prepared.spec.frames;
  check_frame_files(options.output, frames.count());
  ProgressPrinter printer(2);
  printer.remark("starting");
  Farm farm(options.workers, threads);
  JobState job;
  try {
    Server server(Settings{.server = farm.url(), .token = {}, .json = false});
    upload(server, prepared.assets, [](std::uint64_t, std::uint64_t) {});
    const JobId id = job_state_from(post_job(server, prepared.spec)).id;
    const Following how{.least = look, .most = look, .check = [&] { farm.check(printer); }};
    job = job_state_from(follow(
        server, id, [&](const Json& object) { printer.show(job_state_from(object)); }, how));
    printer.finish();
    if (job.state != "done") return outcome(job);
    for (std::uint32_t i = 0; i < frames.count(); ++i)
      fetch_frame(server, id, frames.number(i), format, shown,
                  file_of_frame(options.output, frames.number(i)));
  } catch (const Error& error) {
    printer.finish();
    if (error.kind() == ErrorKind::unreachable)
      farm.check(printer);  // the reason rather than the symptom
    throw;
  }
  const double total = elapsed();
  if (settings.json) print_json(report(options, prepared, job, threads, total));
  const Rect window = prepared.spec.render.window();
  if (!settings.json)
    fmt::print("{}: {}x{}, {} samples a pixel, {:.1f} s (rendering {:.1f} s, {} rays/s)\n",
               options.output.string(), window.width, window.height, job.samples, total,
               job.render_seconds,
               count_text(static_cast<double>(job.rays) / std::max(job.render_seconds, 1e-9)));
  return 0;
}

}  // namespace tessera::client
