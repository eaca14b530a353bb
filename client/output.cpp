#include "client/output.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "common/base/error.hpp"
#include "common/base/random.hpp"

namespace tessera::client {

namespace fs = std::filesystem;

namespace {
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

void fetch_picture(Server& server, const std::string& target, const fs::path& file) {
  const Temporary temporary(folder_of(file) /
                            fmt::format(".{}.{}.part", file.filename().string(), random_hex(4)));
  std::ofstream out(temporary.path, std::ios::binary);
  const auto check = [&] {
    if (!out) throw Error(ErrorKind::failed, fmt::format("{} cannot be written", file.string()));
  };
  check();
  server.download(target, [&](std::span<const std::byte> bytes) {
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

}  // namespace tessera::client
