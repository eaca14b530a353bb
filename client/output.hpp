#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "client/server.hpp"
#include "common/image/view.hpp"
#include "common/job/task.hpp"

namespace tessera::client {

enum class PictureFormat { exr, png };

/// By the file's ending, .exr or .png. Throws Error{bad_input} for another, and if the folder is
/// not there or cannot be written: said before anything renders.
PictureFormat check_output(const std::filesystem::path& file);

/// The route of a frame's picture.
std::string picture_target(JobId job, std::int64_t frame, PictureFormat format, double exposure);

/// How a PNG shows light.
struct Look {
  double exposure = 0;  ///< stops
  image::View view = image::View::srgb;
};
/// Throws Error{bad_input} that names the nearest view.
image::View view_from(const std::string& name);

/// Fetches a picture to `file`: under a temporary name beside it, then renamed. Nothing is left if
/// it fails.
void fetch_picture(Server& server, const std::string& target, const std::filesystem::path& file);
/// A frame's picture, in the file's format. The server makes PNGs in sRGB; by another view they are
/// made here, of its EXR.
void fetch_frame(Server& server, JobId job, std::int64_t frame, PictureFormat format,
                 const Look& look, const std::filesystem::path& file);

}  // namespace tessera::client
