#include "client/output.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <functional>
#include <span>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/base/random.hpp"
#include "common/image/picture.hpp"

namespace tessera::client {

namespace fs = std::filesystem;

namespace {

using Sink = std::function<void(std::span<const std::byte>)>;

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

/// Removes the file unless it was renamed.
struct Temporary {
  fs::path path;
  explicit Temporary(fs::path file) : path(std::move(file)) {}
  ~Temporary() {
    std::error_code ignored;
    fs::remove(path, ignored);
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
};
}  // namespace

PictureFormat check_output(const fs::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  const auto refuse = [&](const std::string& message) {
    throw Error(ErrorKind::bad_input, message, {.file = {}, .key = "--output"});
  };
  if (ending != ".exr" && ending != ".png")
    refuse(
        fmt::format("expected a file name that ends in .exr or .png, found \"{}\"", file.string()));
  std::error_code error;
  if (!fs::is_directory(folder_of(file), error))
    refuse(fmt::format("there is no folder \"{}\"", folder_of(file).string()));
  if (fs::is_directory(file, error)) refuse(fmt::format("\"{}\" is a folder", file.string()));
  if (access(folder_of(file).c_str(), W_OK) != 0)
    refuse(fmt::format("the folder \"{}\" cannot be written: {}", folder_of(file).string(),
                       std::strerror(errno)));
  return ending == ".exr" ? PictureFormat::exr : PictureFormat::png;
}

std::string picture_target(JobId job, std::int64_t frame, PictureFormat format, double exposure) {
  std::string target = fmt::format("/v1/jobs/{}/frames/{}/image.", job, frame);
  if (format == PictureFormat::exr) return target + "exr";
  target += "png";
  if (exposure != 0) target += fmt::format("?exposure={}", exposure);
  return target;
}

image::View view_from(const std::string& name) {
  std::vector<std::string_view> names;
  for (const auto& [known, view] : image::view_names) {
    if (known == name) return view;
    names.push_back(known);
  }
  throw Error(ErrorKind::bad_input, unknown_name("view", name, names),
              {.file = {}, .key = "--view"});
}

namespace {

/// What `write` puts into a stream becomes `file`.
void write_file(const fs::path& file, const std::function<void(const Sink&)>& write) {
  const Temporary temporary(folder_of(file) /
                            fmt::format(".{}.{}.part", file.filename().string(), random_hex(4)));
  std::ofstream out(temporary.path, std::ios::binary);
  const auto check = [&] {
    if (!out) throw Error(ErrorKind::failed, fmt::format("{} cannot be written", file.string()));
  };
  check();
  write([&](std::span<const std::byte> bytes) {
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
    check();
  });
  out.close();
  check();
  std::error_code error;
  fs::rename(temporary.path, file, error);
  if (error)
    throw Error(ErrorKind::failed,
                fmt::format("{} cannot be written: {}", file.string(), error.message()));
}

/// The PNG of an EXR's picture.
std::vector<std::byte> png_of(std::span<const std::byte> exr, const Look& look) {
  const image::ExrImage picture = image::read_exr(exr, "the server's picture");
  std::vector<float> rgb;
  for (const char* channel : {"R", "G", "B"}) {
    const std::span<const float> plane = picture.plane(channel);
    rgb.insert(rgb.end(), plane.begin(), plane.end());
  }
  image::apply_view(look.view, look.exposure, rgb);
  return image::encode_png(picture.width, picture.height, rgb);
}

}  // namespace

void fetch_picture(Server& server, const std::string& target, const fs::path& file) {
  write_file(file, [&](const Sink& sink) { server.download(target, sink); });
}

void fetch_frame(Server& server, JobId job, std::int64_t frame, PictureFormat format,
                 const Look& look, const fs::path& file) {
  if (format == PictureFormat::exr || look.view == image::View::srgb)
    return fetch_picture(server, picture_target(job, frame, format, look.exposure), file);
  std::vector<std::byte> exr;
  server.download(
      picture_target(job, frame, PictureFormat::exr, 0),
      [&](std::span<const std::byte> bytes) { exr.insert(exr.end(), bytes.begin(), bytes.end()); });
  write_file(file, [&](const Sink& sink) { sink(png_of(exr, look)); });
}

}  // namespace tessera::client
