#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/commands.hpp"
#include "client/follow.hpp"
#include "client/frame_files.hpp"
#include "client/output.hpp"
#include "client/print.hpp"
#include "common/base/error.hpp"

namespace tessera::client {

namespace {

std::string text_of(const std::vector<std::int32_t>& frames) {
  std::string text;
  for (const std::int32_t frame : frames)
    text += fmt::format("{}{}", text.empty() ? "" : ",", frame);
  return tessera::text_of(frames_from_text(text));
}

/// Which frames a person wants. Throws Error{not_found} for one that the job has not, or has
/// nothing of yet where it was asked for by --frames.
std::vector<std::int32_t> wanted(const FetchOptions& options, const Json& object) {
  const FrameList has = frames_of_job(object);
  if (options.frame) return {*options.frame};
  std::vector<std::int32_t> ready = frames_with_picture(object, has);
  if (!options.frames) {
    const bool all = options.output.filename().string().find('#') != std::string::npos;
    if (!all) return {static_cast<std::int32_t>(has.first())};
    if (ready.size() < has.count())
      fmt::print(stderr, "tessera: {} of {} frames have no picture yet\n",
                 has.count() - ready.size(), has.count());
    return ready;
  }
  std::vector<std::int32_t> unknown, empty, out;
  for (std::uint32_t i = 0; i < options.frames->count(); ++i) {
    const std::int32_t frame = options.frames->number(i);
    if (!has.contains(frame))
      unknown.push_back(frame);
    else if (!std::binary_search(ready.begin(), ready.end(), frame))
      empty.push_back(frame);
    else
      out.push_back(frame);
  }
  if (!unknown.empty())
    throw Error(ErrorKind::not_found,
                fmt::format("job {} has no frames {}: it has {}", options.job, text_of(unknown),
                            tessera::text_of(has)),
                {.file = {}, .key = "--frames"});
  if (!empty.empty())
    throw Error(ErrorKind::not_found,
                fmt::format("frames {} of job {} have no picture yet", text_of(empty), options.job),
                {.file = {}, .key = "--frames"});
  return out;
}

}  // namespace

int fetch(const Settings& settings, const FetchOptions& options) {
  const PictureFormat format = check_output(options.output);
  const Look look{.exposure = options.exposure, .view = view_from(options.view)};
  check_frame_files(options.output, options.frames ? options.frames->count() : 1);
  Server server(settings);
  const Json object = fetch_job(server, options.job);
  const JobState job = job_state_from(object);
  for (const std::int32_t frame : wanted(options, object)) {
    const std::filesystem::path file = file_of_frame(options.output, frame);
    fetch_frame(server, options.job, frame, format, look, file);
    if (settings.json)
      print_json({{"output", file.string()},
                  {"job", job.id},
                  {"frame", frame},
                  {"state", job.state},
                  {"progress", job.progress}});
  }
  if (!settings.json && job.state != "done")
    fmt::print(stderr, "tessera: the picture so far: job {} is {} at {:.1f} %\n", job.id, job.state,
               job.progress * 100);
  return 0;
}

}  // namespace tessera::client
