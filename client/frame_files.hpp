#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/base/json.hpp"
#include "common/job/frames.hpp"

/// Which frames go to which files. Pure.
namespace tessera::client {

/// The file of one frame: the run of # in the name is the place of its number, filled up with zeros
/// to as many digits as there are #. A name without # is every frame's.
std::filesystem::path file_of_frame(const std::filesystem::path& output, std::int64_t frame);
/// Throws Error{bad_input} that names --output if `count` frames cannot all go there: several need
/// one run of # in the file's name, and there may be no more than one.
void check_frame_files(const std::filesystem::path& output, std::uint32_t count);

/// The frames of the server's job object. Throws Error{failed} if it has none.
FrameList frames_of_job(const Json& job);
/// Those that have a picture, as the object says; all, where it says nothing of so many.
std::vector<std::int32_t> frames_with_picture(const Json& job, const FrameList& frames);

}  // namespace tessera::client
