#include "server/coordinator/frame_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <system_error>

#include "common/base/error.hpp"
#include "common/image/picture.hpp"

namespace tessera::server {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view prefix = "frame-";
constexpr std::string_view suffix = ".exr";
constexpr std::string_view temporary = ".part";

[[noreturn]] void fail(const fs::path& file, const char* what, int code) {
  throw Error(ErrorKind::failed, fmt::format("{}: {}", what, std::generic_category().message(code)),
              {.file = file.string()});
}

/// A file descriptor that closes.
class Descriptor {
 public:
  Descriptor(const fs::path& file, int flags) : fd_(::open(file.c_str(), flags | O_CLOEXEC, 0644)) {
    if (fd_ < 0) fail(file, "cannot be opened", errno);
  }
  ~Descriptor() { ::close(fd_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

void write_all(const fs::path& file, std::span<const std::byte> bytes, bool durable) {
  const Descriptor out(file, O_WRONLY | O_CREAT | O_TRUNC);
  while (!bytes.empty()) {
    const ssize_t written = ::write(out.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(file, "cannot be written", errno);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  if (durable && ::fsync(out.get()) != 0) fail(file, "cannot be synced", errno);
}

}  // namespace

fs::path job_folder(const fs::path& data, JobId job) { return data / "jobs" / std::to_string(job); }

fs::path frame_path(const fs::path& data, JobId job, std::int32_t frame) {
  return job_folder(data, job) / fmt::format("{}{:04}{}", prefix, frame, suffix);
}

std::set<std::int32_t> frames_on_disk(const fs::path& data, JobId job) {
  std::set<std::int32_t> frames;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(job_folder(data, job), none)) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(temporary)) fs::remove(entry.path(), none);
    if (!name.starts_with(prefix) || !name.ends_with(suffix)) continue;
    std::int32_t frame = 0;
    const char* const last = name.data() + name.size() - suffix.size();
    const auto [end, error] = std::from_chars(name.data() + prefix.size(), last, frame);
    if (error == std::errc() && end == last) frames.insert(frame);
  }
  return frames;
}

void write_whole(const fs::path& file, std::span<const std::byte> bytes, bool durable) {
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) fail(file.parent_path(), "cannot be made", error.value());
  const fs::path part = file.string() + std::string(temporary);
  try {
    write_all(part, bytes, durable);
    fs::rename(part, file, error);
    if (error) fail(file, "cannot be renamed to", error.value());
  } catch (...) {
    fs::remove(part, error);
    throw;
  }
  if (!durable) return;
  for (const fs::path& folder : {file.parent_path(), file.parent_path().parent_path()}) {
    const Descriptor directory(folder, O_RDONLY | O_DIRECTORY);
    if (::fsync(directory.get()) != 0) fail(folder, "cannot be synced", errno);
  }
}

std::vector<std::byte> read_whole(const fs::path& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  if (error) fail(file, "cannot be read", error.value());
  std::vector<std::byte> bytes(size);
  std::ifstream in(file, std::ios::binary);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!in) fail(file, "cannot be read", EIO);
  return bytes;
}

std::vector<std::byte> encode_frame_exr(const FilmSnapshot& film, const image::Metadata& metadata) {
  return image::encode_exr(resolve(film), metadata);
}

std::vector<std::byte> encode_frame_png(const FilmSnapshot& film, double exposure_stops) {
  return image::encode_png(film.grid.film_width(), film.grid.film_height(), resolve_rgba(film),
                           exposure_stops);
}

std::vector<std::byte> png_of_file(const fs::path& file, double exposure_stops) {
  const image::ExrImage exr = image::read_exr_file(file);
  std::vector<float> rgb;
  rgb.reserve(3 * exr.plane("R").size());
  for (const char* name : {"R", "G", "B"})
    rgb.insert(rgb.end(), exr.plane(name).begin(), exr.plane(name).end());
  return image::encode_png(exr.width, exr.height, rgb, exposure_stops);
}

FilmSnapshot film_of_file(const fs::path& file, const TileGrid& grid, std::uint64_t version) {
  const image::ExrImage exr = image::read_exr_file(file);
  if (exr.width != grid.film_width() || exr.height != grid.film_height())
    throw Error(ErrorKind::failed, "is not of the film's size", {.file = file.string()});
  FilmSnapshot film{grid, version, {}, std::vector<std::uint64_t>(grid.count(), version)};
  const std::array<std::span<const float>, 4> planes{exr.plane("R"), exr.plane("G"), exr.plane("B"),
                                                     exr.plane("A")};
  for (std::uint32_t index = 0; index < grid.count(); ++index) {
    auto tile = std::make_shared<FilmTile>(empty_film_tile(grid.tile(index)));
    tile->passes = 1;
    tile->samples = {1, 0};  // so that the sums are the means themselves
    const Rect& window = tile->window;
    for (std::size_t c = 0; c < planes.size(); ++c) {
      double* out = tile->sums.data() + c * tile->pixels();
      for (int y = window.y; y < window.y + window.height; ++y)
        for (int x = window.x; x < window.x + window.width; ++x)
          *out++ = static_cast<double>(
              planes[c][static_cast<std::size_t>(y) * static_cast<std::size_t>(exr.width) +
                        static_cast<std::size_t>(x)]);
    }
    film.tiles.push_back(std::move(tile));
  }
  return film;
}

}  // namespace tessera::server
