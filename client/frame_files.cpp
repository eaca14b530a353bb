#include "client/frame_files.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "common/base/error.hpp"

namespace tessera::client {

namespace {

struct Run {
  std::size_t begin = 0, length = 0;
};

/// The first run of #; length 0: there is none.
Run run_in(const std::string& name) {
  const std::size_t begin = name.find('#');
  if (begin == std::string::npos) return {};
  return {begin, std::min(name.find_first_not_of('#', begin), name.size()) - begin};
}

}  // namespace

std::filesystem::path file_of_frame(const std::filesystem::path& output, std::int64_t frame) {
  std::string name = output.filename().string();
  const Run run = run_in(name);
  if (run.length == 0) return output;
  const std::string digits = fmt::format("{:0{}}", frame < 0 ? -frame : frame, run.length);
  name.replace(run.begin, run.length, (frame < 0 ? "-" : "") + digits);
  return output.parent_path() / name;
}

void check_frame_files(const std::filesystem::path& output, std::uint32_t count) {
  const std::string name = output.filename().string();
  const Run run = run_in(name);
  const auto refuse = [](const std::string& message) {
    throw Error(ErrorKind::bad_input, message, {.file = {}, .key = "--output"});
  };
  if (name.find('#', run.begin + run.length) != std::string::npos && run.length > 0)
    refuse(
        fmt::format("expected one run of # for the frame's number, found several in \"{}\"", name));
  if (count > 1 && run.length == 0)
    refuse(
        fmt::format("expected a file name with #### for the numbers of {} frames, such as "
                    "frame-####.exr, found \"{}\"",
                    count, name));
}

FrameList frames_of_job(const Json& job) {
  const auto fail = [] { throw Error(ErrorKind::failed, "the server's job object has no frames"); };
  const auto frames = job.find("frames");
  if (frames == job.end() || !frames->is_object()) fail();
  const auto number = [&](const Json& of, const char* key) {
    const auto found = of.find(key);
    if (found == of.end() || !found->is_number_integer()) fail();
    return found->get<std::int32_t>();
  };
  const auto range = [&](const Json& of) {
    return FrameRange{number(of, "first"), number(of, "last"), number(of, "step")};
  };
  const auto ranges = frames->find("ranges");
  if (ranges == frames->end()) return range(*frames);
  FrameList list;
  list.ranges.clear();
  for (const Json& one : *ranges) list.ranges.push_back(range(one));
  if (list.ranges.empty()) fail();
  return list;
}

std::vector<std::int32_t> frames_with_picture(const Json& job, const FrameList& frames) {
  constexpr std::uint32_t said_most = 1000;  // the object names so many
  std::set<std::int64_t> have;
  if (const auto pictures = job.find("pictures"); pictures != job.end() && pictures->is_array())
    for (const Json& picture : *pictures) have.insert(picture.value("frame", INT64_MIN));
  std::vector<std::int32_t> found;
  for (std::uint32_t i = 0; i < frames.count(); ++i) {
    const std::int32_t frame = frames.number(i);
    if (i >= said_most || have.contains(frame)) found.push_back(frame);
  }
  return found;
}

}  // namespace tessera::client
